//! Who imports whom: no circle of files is larger than its crate's ceiling. A circle of a parent and children that take
//! its types is ordinary Rust; the ceilings say how large such circles are today, and that they do not grow.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Files of a crate by their module paths.
type Files = BTreeMap<Vec<String>, PathBuf>;
/// Modules by those that import them.
type Graph = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

/// Largest circle of each crate, in files.
const CRATES: [(&str, usize); 15] = [
    ("lang/src", 16),
    ("firmware/src", 10),
    ("firmware/f5529", 3),
    ("firmware/g2553", 1),
    ("firmware/far/src", 1),
    ("firmware/lower/src", 6),
    ("firmware/micro/src", 2),
    ("host/src", 25),
    ("host/import/src", 6),
    ("host/cell/src", 2),
    ("host/shop/src", 4),
    ("host/desk/src", 1),
    ("host/emulator/src", 3),
    ("host/web/src", 1),
    ("tests/tests", 1),
];

/// The modules of a crate, but for its tests.
fn files(root: &Path) -> Files {
    let mut found = Files::new();
    let mut open = vec![root.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            let inside = path.strip_prefix(root).expect("below").with_extension("");
            let mut names = inside.iter().map(|name| name.to_string_lossy().into_owned());
            let mut names = names.by_ref().collect::<Vec<_>>();
            if path.extension().is_none_or(|kind| kind != "rs")
                || names.last().is_some_and(|n| n == "tests")
            {
                continue;
            }
            names.pop_if(|name| matches!(name.as_str(), "mod" | "lib" | "main"));
            found.insert(names, path);
        }
    }
    found
}

/// The paths of a file.
#[derive(Default)]
struct Paths(Vec<Vec<String>>);

impl Paths {
    fn tree(&mut self, front: &[String], tree: &syn::UseTree) {
        let with = |name: &syn::Ident| [front, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.tree(&with(&path.ident), &path.tree),
            syn::UseTree::Name(name) => self.0.push(with(&name.ident)),
            syn::UseTree::Rename(name) => self.0.push(with(&name.ident)),
            syn::UseTree::Glob(_) => self.0.push(front.to_vec()),
            syn::UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.tree(front, tree))
            }
        }
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    let is = |it: &syn::Attribute| {
        it.path().is_ident("cfg")
            && it.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
    };
    attributes.iter().any(is)
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        // What a parent gives on of its children is no way back up.
        if matches!(item.vis, syn::Visibility::Inherited) && !is_test(&item.attrs) {
            self.tree(&[], &item.tree);
        }
    }
    // `pub(super)` is no import.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}
    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.0.push(path.segments.iter().map(|part| part.ident.to_string()).collect());
        visit::visit_path(self, path);
    }
}

/// The module that a path in `from` leads to.
fn target(files: &Files, from: &[String], path: &[String]) -> Option<Vec<String>> {
    let mut at = from.to_vec();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => at.clear(),
        "self" => {}
        "super" => {
            while rest.first().is_some_and(|name| name == "super") {
                at.pop();
                rest = &rest[1..];
            }
            rest = &path[path.len() - rest.len() - 1..];
        }
        // A child by its bare name.
        child => {
            at.push(child.to_owned());
            if !files.contains_key(&at) {
                return None;
            }
        }
    }
    at.extend_from_slice(&rest[1..]);
    let found = (1..=at.len()).rev().map(|n| &at[..n]).find(|part| files.contains_key(*part))?;
    (found != from).then(|| found.to_vec())
}

fn graph(files: &Files) -> Graph {
    let mut graph = Graph::new();
    for (name, path) in files {
        let text = fs::read_to_string(path).expect("readable");
        let file =
            syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut paths = Paths::default();
        paths.visit_file(&file);
        let targets = paths.0.iter().filter_map(|path| target(files, name, path));
        graph.insert(name.clone(), targets.collect());
    }
    graph
}

fn reached(graph: &Graph, from: &[String]) -> BTreeSet<Vec<String>> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from.to_vec()];
    while let Some(at) = open.pop() {
        for next in &graph[&at] {
            if seen.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    seen
}

/// Modules each of which leads to every other.
fn circles(graph: &Graph) -> Vec<BTreeSet<String>> {
    let reached = graph.keys().map(|name| (name, reached(graph, name))).collect::<BTreeMap<_, _>>();
    let mut found = BTreeSet::new();
    for (name, from_here) in &reached {
        let circle = from_here.iter().filter(|other| reached[other].contains(*name));
        let circle = circle.map(|name| name.join("::")).collect::<BTreeSet<_>>();
        if circle.len() > 1 {
            found.insert(circle);
        }
    }
    found.into_iter().collect()
}

#[test]
fn no_circle_of_imports_is_large() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut wrong = Vec::new();
    for (part, most) in CRATES {
        let files = files(&root.join(part));
        assert!(!files.is_empty(), "{part} has no files");
        let circles = circles(&graph(&files));
        let largest = circles.iter().map(BTreeSet::len).max().unwrap_or(1);
        println!("{part}: {largest} files in the largest circle");
        for circle in circles {
            if circle.len() > most {
                wrong.push(format!("{part}: {circle:?}"));
            }
        }
        if largest < most {
            wrong.push(format!("{part}: lower its ceiling from {most} to {largest}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "circles that are not what their ceilings say:\n{}",
        wrong.join("\n")
    );
}

/// A crate that the workspace gets is looked at, too: one that is missing has no ceiling.
#[test]
fn every_crate_has_its_ceiling() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = fs::read_to_string(root.join("Cargo.toml")).expect("readable");
    let members = text.lines().find_map(|line| line.strip_prefix("members = [")).expect("members");
    let members = members.trim_end_matches(']').split(", ").map(|name| name.trim_matches('"'));
    for member in members {
        let sources = [member.to_owned() + "/src", member.to_owned() + "/tests"];
        let known = CRATES.iter().any(|(part, _)| sources.iter().any(|own| own == part));
        assert!(known, "{member} has no ceiling");
    }
}

#[test]
fn a_circle_is_found_whichever_way_it_is_written() {
    let name = |text: &str| text.split("::").map(str::to_owned).collect::<Vec<_>>();
    let files = ["a", "a::b", "c"].map(|text| (name(text), PathBuf::new())).into_iter().collect();
    assert_eq!(target(&files, &name("a::b"), &name("super::super::c::Thing")), Some(name("c")));
    assert_eq!(target(&files, &name("a::b"), &name("super::Thing")), Some(name("a")));
    assert_eq!(target(&files, &name("c"), &name("crate::a::b::made")), Some(name("a::b")));
    assert_eq!(target(&files, &name("a"), &name("self::b::Thing")), Some(name("a::b")));
    assert_eq!(target(&files, &name("c"), &name("std::fs")), None);
    assert_eq!(target(&files, &name("a"), &name("b::Thing")), Some(name("a::b")));
    assert_eq!(target(&files, &name("c"), &name("b::Thing")), None);
    let to = |text: &str| BTreeSet::from([name(text)]);
    let graph =
        Graph::from([(name("a"), to("a::b")), (name("a::b"), to("c")), (name("c"), to("a"))]);
    assert_eq!(circles(&graph).len(), 1);
    assert_eq!(circles(&graph)[0].len(), 3);
}
