//! The library as hosts meet it: C and C++ programs, compiled strictly, linked statically and dynamically, and run.

mod common;

use common::{LIBRARY, Language, Linkage, WARNINGS, run};

const SAMPLES: [&str; 16] = [
    "hello",
    "chain",
    "bulk",
    "misuse",
    "edit",
    "queries",
    "debug_draw",
    "events",
    "record",
    "rollback",
    "tower",
    "keystone",
    "fixed_step",
    "publish",
    "renderer",
    "track",
];

fn sample(name: &str) -> std::path::PathBuf {
    common::repository().join("examples_c").join(format!("{name}.c"))
}

fn host(name: &str) -> std::path::PathBuf {
    common::repository().join("capi/tests/hosts").join(format!("{name}.c"))
}

#[test]
fn samples_and_header_compile_without_a_warning_as_c_and_as_cpp() {
    for name in SAMPLES {
        LIBRARY.compile(&sample(name), Language::Cpp11, Linkage::Static);
    }
    let header = common::repository().join("include/longspan/longspan.h");
    // C23 is c2x to compilers that came before it.
    for (compiler, standard, language) in [
        ("cc", "c99", "c"),
        ("cc", "c11", "c"),
        ("cc", "c17", "c"),
        ("cc", "c2x", "c"),
        ("g++", "c++11", "c++"),
        ("g++", "c++14", "c++"),
        ("g++", "c++17", "c++"),
        ("g++", "c++20", "c++"),
    ] {
        run(std::process::Command::new(compiler)
            .args(WARNINGS)
            .arg(format!("-std={standard}"))
            .args(["-fsyntax-only", "-x", language])
            .arg(&header));
    }
}

#[test]
fn the_compiler_line_at_the_top_of_each_sample_works() {
    for name in SAMPLES {
        let text = std::fs::read_to_string(sample(name)).expect("the sample is there");
        let line =
            text.lines().find_map(|line| line.trim_start_matches([' ', '*']).strip_prefix("cc ")).expect("a compiler line");
        let (compile, _) = line.split_once(" -o ").expect("it names the program");
        let folder = format!("-L{}", LIBRARY.folder().display());
        let arguments = compile.split_whitespace().map(|word| if word == "-L../target/release" { &folder } else { word });
        let program = common::output_folder().join(format!("{name}-by-hand"));
        let mut command = std::process::Command::new("cc");
        run(command.args(arguments).arg("-o").arg(program).current_dir(common::repository().join("examples_c")));
        assert!(line.trim_end_matches(" */").ends_with(&format!("-o {name} && ./{name}")), "{line}");
    }
}

#[test]
fn the_box_of_hello_comes_to_rest_on_the_ground() {
    let output = run(&mut LIBRARY.compile(&sample("hello"), Language::C99, Linkage::Static));
    let last = output.lines().last().expect("hello prints poses");
    let height: f64 = last.split_whitespace().nth(4).and_then(|y| y.parse().ok()).expect("the height is printed");
    assert_eq!(output.lines().count(), 12, "{output}");
    assert!((height - 0.5).abs() < 1.0e-3, "the centre of a box of 1 m lies at {height} m");
}

#[test]
fn a_program_linked_dynamically_does_the_same_as_one_linked_statically() {
    let linked_statically = run(&mut LIBRARY.compile(&sample("hello"), Language::C99, Linkage::Static));
    let linked_dynamically = run(&mut LIBRARY.compile(&sample("hello"), Language::C99, Linkage::Dynamic));
    assert_eq!(linked_statically, linked_dynamically);
}

#[test]
fn chain_prints_its_measures_and_writes_a_picture_of_every_body() {
    let picture = common::output_folder().join("chain.txt");
    let output = run(LIBRARY.compile(&sample("chain"), Language::C99, Linkage::Static).arg("10000").arg(&picture));
    let value = |name: &str| -> f64 {
        let line = output.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name} is printed: {output}"));
        line[name.len()..].split_whitespace().next().and_then(|v| v.parse().ok()).expect("a number follows")
    };
    for name in ["stretch", "worst gap", "top joint", "CPU time"] {
        assert!(value(name).is_finite(), "{name}: {}", value(name));
    }
    let picture = std::fs::read_to_string(picture).expect("the picture is written");
    let bodies: Vec<Vec<&str>> = picture.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(bodies.len(), 32, "anchor, 30 links and weight");
    let dimensions = |kind: &str| if kind == "box" { 3 } else { 2 };
    let complete = |body: &Vec<&str>| body.len() == 1 + dimensions(body[0]) + 7;
    assert!(bodies.iter().all(complete), "kind, its dimensions, 3 + 4 numbers of the pose: {picture}");
    assert!(bodies.iter().all(|body| body[1..].iter().all(|n| n.parse().is_ok_and(f64::is_finite))), "{picture}");
    assert_eq!((bodies[0][0], bodies[1][0], bodies[31][0]), ("box", "capsule", "box"));
}

#[test]
fn bulk_draws_a_thousand_bodies_where_they_are() {
    let output = run(&mut LIBRARY.compile(&sample("bulk"), Language::C99, Linkage::Static));
    assert!(output.starts_with("1000 bodies"), "{output}");
}

#[test]
fn what_is_changed_in_a_live_world_comes_back_as_it_was_set() {
    let output = run(&mut LIBRARY.compile(&sample("edit"), Language::C99, Linkage::Static));
    let changes: u32 = output.split_whitespace().next().and_then(|count| count.parse().ok()).expect("a number is printed");
    assert!(changes >= 16, "{output}");
}

#[test]
fn questions_are_answered_and_filtered_as_the_host_says() {
    let output = run(&mut LIBRARY.compile(&sample("queries"), Language::C99, Linkage::Static));
    assert!(output.contains("asked about 10 shapes, the host accepted 5"), "{output}");
}

#[test]
fn what_is_drawn_is_what_is_there() {
    let output = run(&mut LIBRARY.compile(&sample("debug_draw"), Language::C99, Linkage::Static));
    assert!(output.lines().count() == 16 && output.contains("the rope's ends: slack"), "{output}");
}

#[test]
fn a_step_tells_of_hits_sensors_and_stops() {
    let output = run(&mut LIBRARY.compile(&sample("events"), Language::C99, Linkage::Static));
    assert!(output.contains("entered 1, left 1") && output.lines().count() == 3, "{output}");
}

#[test]
fn a_recording_is_played_to_the_same_bits_and_a_change_in_it_is_named() {
    let output = run(&mut LIBRARY.compile(&sample("record"), Language::C99, Linkage::Static));
    assert!(output.contains("the same bits: yes") && output.contains("add_impulse in step 31"), "{output}");
}

#[test]
fn a_host_s_allocator_profiler_and_policy_are_asked() {
    for linkage in [Linkage::Static, Linkage::Dynamic] {
        let output = run(&mut LIBRARY.compile(&host("hooks"), Language::C99, linkage));
        assert!(
            output
                .contains("longspan step;find pairs;update contacts;group islands;derive long range;solve;finish;judge support;"),
            "{output}"
        );
    }
}

#[test]
fn a_host_that_goes_back_gets_the_same_bits_again() {
    let output = run(&mut LIBRARY.compile(&sample("rollback"), Language::C99, Linkage::Static));
    assert!(output.contains("120 steps, the same bits twice") && output.contains("snapshot: is corrupted"), "{output}");
}

#[test]
fn a_tower_counts_its_supported_blocks_through_its_collapse() {
    let output = run(&mut LIBRARY.compile(&sample("tower"), Language::C99, Linkage::Static));
    assert!(output.lines().count() == 16 && output.contains("1.00 s: 400 of 400 blocks supported"), "{output}");
}

#[test]
fn what_is_said_to_fall_without_a_post_falls() {
    let output = run(&mut LIBRARY.compile(&sample("keystone"), Language::C99, Linkage::Static));
    assert!(output.contains("support is lost by 2: lintel; finial;") && output.contains("block aside  stands"), "{output}");
}

#[test]
fn frames_between_steps_are_drawn_evenly() {
    let output = run(&mut LIBRARY.compile(&sample("fixed_step"), Language::C99, Linkage::Static));
    assert!(output.contains("steps in 288 frames"), "{output}");
}

#[test]
fn the_chain_of_the_guide_hangs_as_the_guide_says() {
    let guide = std::fs::read_to_string(common::repository().join("docs/guide/hello.md")).expect("the guide is there");
    let code = guide.split("```c\n").nth(1).and_then(|rest| rest.split("```").next()).expect("the guide has a program");
    let source = common::output_folder().join("hang.c");
    std::fs::write(&source, code).expect("a source can be written");
    let output = run(&mut LIBRARY.compile(&source, Language::C99, Linkage::Static));
    assert_eq!(output, "the weight hangs 1.900 m below the ceiling, which carries 1069 N\n");
    assert!(guide.contains("the weight hangs 1.900 m below the ceiling, which carries 1069 N"), "the guide says so");
}

#[test]
fn every_misuse_gets_its_own_error() {
    let output = run(&mut LIBRARY.compile(&sample("misuse"), Language::C99, Linkage::Static));
    let checks = output.lines().filter(|line| line.starts_with("ok")).count();
    assert!(checks > 120, "only {checks} checks ran");
    assert!(output.ends_with("\n0 unexpected\n"), "{output}");
}

#[test]
fn misuse_touches_no_memory_that_it_should_not() {
    let misuse = LIBRARY.compile(&sample("misuse"), Language::C99, Linkage::Static);
    let valgrind = std::process::Command::new("valgrind")
        .args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite"])
        .arg(misuse.get_program())
        .output();
    match valgrind {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => println!("skipped: valgrind cannot be run ({error})"),
    }
}

#[test]
fn the_host_s_floating_point_settings_neither_matter_nor_change() {
    let output = run(&mut LIBRARY.compile(&host("float_environment"), Language::C99, Linkage::Static));
    let hashes: Vec<&str> = output.split([' ', ',']).take(3).collect();
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{output}");
}

#[test]
fn the_host_s_job_system_gives_the_bits_of_the_library_s_own_threads() {
    let mut compiled = LIBRARY.compile(&host("jobs"), Language::C99, Linkage::Static);
    let output = run(&mut compiled);
    let lines: Vec<Vec<&str>> = output.lines().map(|line| line.split(' ').collect()).collect();
    assert_eq!(lines.len(), 7, "{output}");
    assert!(lines.iter().all(|line| line[1..4] == lines[0][1..4]), "{output}");
    let jobs = |name: &str| lines.iter().find(|line| line[0] == name).and_then(|line| line[4].parse::<u32>().ok());
    assert!(["host-1", "host-2", "host-4", "inline", "idle"].iter().all(|name| jobs(name) >= Some(60)), "{output}");
}

#[test]
fn a_library_without_streams_has_their_functions_and_says_so() {
    for name in ["publish", "renderer"] {
        let output = run(&mut LIBRARY.compile(&sample(name), Language::C99, Linkage::Static));
        assert_eq!(output, "this library was built without streams\n", "{name}");
    }
    run(&mut LIBRARY.compile(&host("no_streams"), Language::C99, Linkage::Static));
}

#[test]
fn a_library_without_streams_does_not_depend_on_iceoryx2() {
    let tree = |features: &[&str]| {
        let mut cargo = std::process::Command::new(env!("CARGO"));
        cargo.args(["tree", "--offline", "--package", "longspan-capi", "--edges", "normal", "--prefix", "none"]);
        run(cargo.args(features).current_dir(common::repository()))
    };
    assert!(!tree(&[]).contains("iceoryx2"));
    assert!(tree(&["--features", "stream"]).contains("iceoryx2 v"), "the feature is what brings it");
}

#[test]
fn the_wrapper_for_cpp_owns_throws_and_steps() {
    let source = common::repository().join("capi/tests/hosts/wrapper.cpp");
    let output = run(&mut LIBRARY.compile(&source, Language::Cpp17, Linkage::Dynamic));
    assert_eq!(output.trim(), "ls_body_pose_get: body: object was destroyed");
}

#[test]
fn the_wrapper_for_cpp_has_the_rest_of_the_library_too() {
    let source = common::repository().join("capi/tests/hosts/wrapper_features.cpp");
    let output = run(&mut LIBRARY.compile(&source, Language::Cpp17, Linkage::Static));
    assert_eq!(output.trim(), "0 failures");
}

#[test]
fn only_functions_of_the_header_are_exported_and_all_of_them() {
    let symbols = run(std::process::Command::new("nm").args(["--dynamic", "--defined-only"]).arg(LIBRARY.shared()));
    let mut exported: Vec<&str> = symbols.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    exported.sort_unstable();
    let header = std::fs::read_to_string(common::repository().join("include/longspan/longspan.h")).expect("the header is there");
    let declaration = |line: &'static str| line.split('(').next()?.split([' ', '*']).next_back();
    let header: &'static str = header.leak();
    let mut declared: Vec<&str> = header
        .lines()
        .filter(|line| line.starts_with("LsResult ls_") || line.starts_with("const char *ls_"))
        .filter_map(declaration)
        .collect();
    declared.sort_unstable();
    assert!(exported.len() > 70, "only {} symbols", exported.len());
    assert_eq!(exported, declared);
}

#[test]
fn the_shared_library_has_its_soname() {
    let dynamic = run(std::process::Command::new("readelf").arg("--dynamic").arg(LIBRARY.shared()));
    assert!(dynamic.contains("[liblongspan.so.0]"), "{dynamic}");
}
