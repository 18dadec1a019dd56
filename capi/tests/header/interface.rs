//! The binary interface that a header describes, read from its text, and what a host of an older one would not survive.

use std::collections::BTreeMap;
use std::fmt;

/// Everything that a compiled host depends on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interface {
    /// Value of each constant.
    pub constants: BTreeMap<String, String>,
    /// Type of each typedef that is not a struct.
    pub types: BTreeMap<String, String>,
    /// Declaration of each function, without names of parameters.
    pub functions: BTreeMap<String, String>,
    pub structs: BTreeMap<String, Struct>,
}

/// A struct: whether it grows, and its fields in order, as `type name`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Struct {
    pub grows: bool,
    pub fields: Vec<String>,
}

impl Interface {
    /// Reads a header as this project writes it.
    pub fn of_header(header: &str) -> Self {
        let mut interface = Self::default();
        let comments: Vec<&str> = header.split("/*").skip(1).map(|rest| rest.split("*/").next().unwrap_or_default()).collect();
        let code = without_comments(header);
        for line in code.lines().filter_map(|line| line.strip_prefix("#define LS_")) {
            let (name, value) = line.split_once(' ').expect("a constant has a value");
            interface.constants.insert(format!("LS_{name}"), value.trim().to_owned());
        }
        let code: String = code.lines().filter(|line| !line.starts_with('#') && !line.starts_with("extern \"C\"")).collect();
        for (name, body) in structs(&code) {
            let fields: Vec<String> =
                body.split(';').map(spaced).filter(|field| !field.is_empty()).map(|field| field.replace("struct ", "")).collect();
            let says_so = |comment: &&str| comment.contains("Later versions append fields") && precedes(header, comment, &name);
            let grows = fields.first().is_some_and(|field| field == "uint32_t struct_size") || comments.iter().any(says_so);
            interface.structs.insert(name, Struct { grows, fields });
        }
        for statement in code.split(';').map(spaced) {
            if let Some(declaration) = statement.strip_prefix("typedef ").filter(|rest| !rest.starts_with("struct ")) {
                interface.types.insert(declared_name(declaration), declaration.replace("struct ", ""));
            } else if let Some(at) = statement.find("LsResult ls_").or(statement.find("const char *ls_")) {
                let declaration = statement[at..].replace("struct ", "");
                let name = declaration.split('(').next().unwrap_or_default().rsplit([' ', '*']).next().unwrap_or_default();
                interface.functions.insert(name.to_owned(), without_names(&declaration));
            }
        }
        interface
    }

    /// Reads what `Display` writes.
    pub fn parse(text: &str) -> Self {
        let mut interface = Self::default();
        let mut last = String::new();
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
            let (kind, rest) = line.split_once(' ').unwrap_or((line, ""));
            let pair = || rest.split_once(" = ").map(|(name, value)| (name.to_owned(), value.to_owned())).expect("name = value");
            match kind {
                "constant" => drop(interface.constants.insert(pair().0, pair().1)),
                "type" => drop(interface.types.insert(pair().0, pair().1)),
                "function" => drop(interface.functions.insert(pair().0, pair().1)),
                "struct" => {
                    let (name, how) = pair();
                    interface.structs.insert(name.clone(), Struct { grows: how == "grows", fields: Vec::new() });
                    last = name;
                }
                "field" => interface.structs.get_mut(&last).expect("a field belongs to a struct").fields.push(rest.to_owned()),
                _ => panic!("not a line of an interface: {line}"),
            }
        }
        interface
    }

    /// The number of the interface.
    pub fn number(&self) -> u32 {
        self.constants.get("LS_ABI_VERSION").and_then(|value| value.parse().ok()).expect("the header has LS_ABI_VERSION")
    }

    /// What a host compiled for this interface would not survive in `new`; additions are none.
    pub fn broken_by(&self, new: &Self) -> Vec<String> {
        let mut broken = Vec::new();
        let mut same = |kind: &str, old: &BTreeMap<String, String>, new: &BTreeMap<String, String>| {
            for (name, value) in old {
                match new.get(name) {
                    None => broken.push(format!("{kind} {name} is gone")),
                    Some(now) if now != value => broken.push(format!("{kind} {name} was `{value}` and is `{now}`")),
                    Some(_) => {}
                }
            }
        };
        // The numbers of the version itself change with it.
        let lasting = |constants: &BTreeMap<String, String>| {
            constants.clone().into_iter().filter(|(name, _)| !name.contains("_VERSION")).collect::<BTreeMap<_, _>>()
        };
        same("constant", &lasting(&self.constants), &lasting(&new.constants));
        same("type", &self.types, &new.types);
        same("function", &self.functions, &new.functions);
        for (name, old) in &self.structs {
            let Some(now) = new.structs.get(name) else {
                broken.push(format!("struct {name} is gone"));
                continue;
            };
            let same = |(old, now): (&String, &String)| old == now || is_named_reserve(old, now);
            let is_shorter = now.fields.len() < old.fields.len();
            if is_shorter || !old.fields.iter().zip(&now.fields).all(same) {
                broken.push(format!("struct {name}: its fields were {:?} and are {:?}", old.fields, now.fields));
            } else if now.fields.len() > old.fields.len() && !old.grows {
                broken.push(format!("struct {name} never grows, and has a new field"));
            } else if old.grows && !now.grows {
                broken.push(format!("struct {name} no longer grows"));
            }
        }
        broken
    }
}

impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (kind, names) in [("constant", &self.constants), ("type", &self.types), ("function", &self.functions)] {
            for (name, value) in names {
                writeln!(f, "{kind} {name} = {value}")?;
            }
        }
        for (name, Struct { grows, fields }) in &self.structs {
            writeln!(f, "struct {name} = {}", if *grows { "grows" } else { "fixed" })?;
            fields.iter().try_for_each(|field| writeln!(f, "field {field}"))?;
        }
        Ok(())
    }
}

/// Whether a field that was kept in reserve, and was zero, has been given a name.
fn is_named_reserve(old: &str, now: &str) -> bool {
    let (was, is) = (old.rsplit_once(' '), now.rsplit_once(' '));
    matches!((was, is), (Some((type_before, "reserved")), Some((type_now, _))) if type_before == type_now)
}

fn without_comments(text: &str) -> String {
    let mut parts = text.split("/*");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |code, part| code + part.split_once("*/").map_or("", |(_, rest)| rest))
}

/// Name and body of every struct.
fn structs(code: &str) -> impl Iterator<Item = (String, String)> + '_ {
    code.split("typedef struct ").skip(1).map(|rest| {
        let (name, rest) = rest.split_once('{').expect("a struct has a body");
        let body = rest.split('}').next().unwrap_or_default();
        (name.trim().to_owned(), body.to_owned())
    })
}

/// Whether a comment is the one right before a struct.
fn precedes(header: &str, comment: &str, name: &str) -> bool {
    let after = header.split_once(comment).map_or("", |(_, rest)| rest);
    after.trim_start_matches("*/").trim_start().starts_with(&format!("typedef struct {name} "))
}

/// One space wherever there is any.
fn spaced(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `int32_t LsResult` and `uint32_t (*LsCallback)(...)` declare the last word before the parameters.
fn declared_name(declaration: &str) -> String {
    let head = declaration.split_once("(*").map_or(declaration, |(_, rest)| rest.split(')').next().unwrap_or_default());
    head.rsplit(' ').next().unwrap_or_default().to_owned()
}

/// A declaration without the names of its parameters, which no compiled host knows.
fn without_names(declaration: &str) -> String {
    let (head, parameters) = declaration.split_once('(').unwrap_or((declaration, ""));
    let parameters = parameters.trim_end_matches(')').split(',').map(|parameter| {
        let parameter = parameter.trim();
        let (named, array) = parameter.find('[').map_or((parameter, ""), |at| parameter.split_at(at));
        let end = named.rfind([' ', '*']).map_or(named.len(), |at| at + 1);
        format!("{}{array}", named[..end].trim_end())
    });
    format!("{head}({})", parameters.collect::<Vec<_>>().join(", "))
}
