//! Licences of the libraries that a build contains, with their texts, as cargo knows them.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use tinyjson::JsonValue;

use crate::install::Wish;
use crate::library::{cargo, field};
use crate::{Outcome, printed};

type Object = HashMap<String, JsonValue>;

/// What is said to whoever is given the library.
pub fn text(wish: &Wish) -> Outcome<String> {
    let mut command = cargo();
    command.args(["metadata", "--format-version", "1", "--locked", "--filter-platform"]);
    command.arg(wish.target.as_deref().unwrap_or(env!("LONGSPAN_HOST")));
    command.args(wish.features.iter().flat_map(|features| ["--features".to_owned(), format!("longspan-capi/{features}")]));
    let metadata: JsonValue = printed(&mut command)?.parse()?;
    let packages = named(&metadata, "packages", "id")?;
    let resolved = metadata.get::<Object>().and_then(|all| all.get("resolve")).ok_or("cargo does not resolve")?;
    let contained = contained(&named(resolved, "nodes", "id")?)?;

    let mut text = String::from("longspan contains these libraries. Their licences follow, each text once.\n\n");
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for id in &contained {
        let package = packages.get(id).ok_or_else(|| format!("cargo does not know {id}"))?;
        let Some(source) = field::<String>(package, "source") else { continue };
        let value = |name: &str| field::<String>(package, name).cloned().unwrap_or_default();
        let name = format!("{} {}", value("name"), value("version"));
        let licence = value("license");
        if licence.is_empty() {
            return Err(format!("{name} of {source} names no licence").into());
        }
        writeln!(text, "{name}: {licence}, {}", value("repository"))?;
        for found in licences(Path::new(&value("manifest_path")))? {
            texts.entry(found).or_default().push(name.clone());
        }
    }
    for (licence, owners) in &texts {
        write!(text, "\n{}\n{}\n\n{}\n", "-".repeat(80), owners.join(", "), licence.trim())?;
    }
    Ok(text)
}

/// Objects of a list by one of their fields.
fn named(object: &JsonValue, list: &str, key: &str) -> Outcome<BTreeMap<String, JsonValue>> {
    let list = field::<Vec<JsonValue>>(object, list).ok_or_else(|| format!("cargo gives no {list}"))?;
    Ok(list.iter().filter_map(|entry| Some((field::<String>(entry, key)?.clone(), entry.clone()))).collect())
}

/// What the C library is built of, code that only builds or tests it left out.
fn contained(nodes: &BTreeMap<String, JsonValue>) -> Outcome<BTreeSet<String>> {
    let root =
        nodes.keys().find(|id| id.contains("longspan-capi") || id.contains("/capi#")).ok_or("longspan-capi is not there")?;
    let (mut contained, mut waiting) = (BTreeSet::new(), vec![root.clone()]);
    while let Some(id) = waiting.pop() {
        let dependencies = nodes.get(&id).and_then(|node| field::<Vec<JsonValue>>(node, "deps")).cloned().unwrap_or_default();
        if !contained.insert(id) {
            continue;
        }
        for dependency in &dependencies {
            let kinds = field::<Vec<JsonValue>>(dependency, "dep_kinds").cloned().unwrap_or_default();
            let is_linked = kinds.iter().any(|kind| field::<String>(kind, "kind").is_none());
            waiting.extend(field::<String>(dependency, "pkg").filter(|_| is_linked).cloned());
        }
    }
    Ok(contained)
}

/// Texts that lie beside a library's manifest.
fn licences(manifest: &Path) -> Outcome<Vec<String>> {
    let folder = manifest.parent().ok_or("a manifest lies in a folder")?;
    let mut files: Vec<_> = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?.iter().map(std::fs::DirEntry::path).collect();
    files.retain(|file| {
        let name = file.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        file.is_file()
            && ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE", "COPYRIGHT"].iter().any(|start| name.starts_with(start))
    });
    files.sort();
    files.iter().map(|file| Ok(String::from_utf8_lossy(&fs::read(file)?).replace("\r\n", "\n"))).collect()
}
