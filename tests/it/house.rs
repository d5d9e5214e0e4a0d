//! The house: which folder may use which, and that nothing uses itself in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

use crate::common::repository;

/// The folders of `src/` from the bottom to the top; those on a line do not use each other. Each uses only what is below.
const FLOORS: [&[&str]; 19] = [
    &["deadline", "error"],
    &["geometry", "named"],
    &["mujoco", "plausible"],
    &["creature"],
    &["schema"],
    &["kinematics", "model_files"],
    &["skin"],
    &["agent", "given_file", "given_number"],
    &["ground_truth", "senses"],
    &["learning"],
    &["calibration", "simulation"],
    &["evaluation", "peripersonal"],
    &["babbling"],
    &["export"],
    &["session"],
    &["interaction"],
    &["study"],
    &["view"],
    &["cli"],
];

/// A path of modules below the crate, such as `learning::growth`.
type Module = Vec<String>;

/// The modules of the crate: what each uses, and what it re-exports from where.
#[derive(Default)]
struct Modules {
    uses: BTreeMap<Module, Vec<Vec<String>>>,
    exports: BTreeMap<Module, BTreeMap<String, Vec<String>>>,
}

impl Modules {
    fn of(source: &Path) -> Modules {
        let mut modules = Modules::default();
        modules.read_folder(source, &mut Vec::new());
        modules
    }

    fn read_folder(&mut self, folder: &Path, module: &mut Module) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_string();
            let is_root = matches!(name.as_str(), "mod" | "lib" | "main");
            if !is_root {
                module.push(name);
            }
            if path.is_dir() {
                self.read_folder(&path, module);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                self.read_file(&path, module);
            }
            if !is_root {
                module.pop();
            }
        }
    }

    fn read_file(&mut self, path: &Path, module: &Module) {
        let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
        let mut paths = Paths { module, found: Vec::new() };
        paths.visit_file(&file);
        self.uses.entry(module.clone()).or_default().extend(paths.found);
        for item in &file.items {
            let Item::Use(item) = item else { continue };
            if matches!(item.vis, Visibility::Inherited) {
                continue;
            }
            let mut leaves = Vec::new();
            leaves_of(&item.tree, &mut Vec::new(), &mut leaves);
            for (name, path) in leaves {
                let path = absolute(&path, module).unwrap_or_else(|| [module.clone(), path].concat());
                self.exports.entry(module.clone()).or_default().insert(name, path);
            }
        }
    }

    /// The module that a path leads to, through re-exports.
    fn home(&self, path: &[String]) -> Module {
        let mut path = path.to_vec();
        // A re-export of a re-export is as deep as it gets.
        for _ in 0..4 {
            let length =
                (0..=path.len()).rev().find(|&length| self.uses.contains_key(&path[..length])).unwrap_or(0);
            let (module, rest) = path.split_at(length);
            let exported = rest.first().and_then(|name| self.exports.get(module)?.get(name));
            match exported {
                Some(exported) => path = [exported.clone(), rest[1..].to_vec()].concat(),
                None => return module.to_vec(),
            }
        }
        path
    }

    /// Which module uses which other one.
    fn edges(&self) -> BTreeSet<(Module, Module)> {
        let uses = self.uses.iter().flat_map(|(module, paths)| paths.iter().map(move |path| (module, path)));
        uses.map(|(module, path)| (module.clone(), self.home(path))).filter(|(a, b)| a != b).collect()
    }
}

/// All paths of a file that begin in the crate, as modules and what is in them. Tests may use anything.
struct Paths<'a> {
    module: &'a Module,
    found: Vec<Vec<String>>,
}

impl<'ast> Visit<'ast> for Paths<'_> {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let mut leaves = Vec::new();
        leaves_of(&item.tree, &mut Vec::new(), &mut leaves);
        self.found.extend(leaves.iter().filter_map(|(_, path)| absolute(path, self.module)));
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.found.extend(absolute(&names, self.module));
        visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let is_test = item.attrs.iter().any(|attribute| attribute.path().is_ident("cfg"));
        if !is_test || item.content.is_none() {
            visit::visit_item_mod(self, item);
        }
    }
}

/// The names that a `use` brings, each with its path.
pub fn leaves_of(tree: &UseTree, path: &mut Vec<String>, leaves: &mut Vec<(String, Vec<String>)>) {
    match tree {
        UseTree::Path(inner) => {
            path.push(inner.ident.to_string());
            leaves_of(&inner.tree, path, leaves);
            path.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves_of(tree, path, leaves)),
        UseTree::Glob(_) => leaves.push(("*".to_string(), path.clone())),
        UseTree::Name(name) => leaf(name.ident.to_string(), name.ident.to_string(), path, leaves),
        UseTree::Rename(name) => leaf(name.rename.to_string(), name.ident.to_string(), path, leaves),
    }
}

fn leaf(name: String, last: String, path: &[String], leaves: &mut Vec<(String, Vec<String>)>) {
    let last = Some(last).filter(|last| last != "self");
    leaves.push((name, path.iter().cloned().chain(last).collect()));
}

/// A path from the crate's root; `None` if it does not begin in the crate.
fn absolute(path: &[String], module: &Module) -> Option<Vec<String>> {
    let above = path.iter().take_while(|name| *name == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([&module[..], &path[1..]].concat()),
        "super" if above <= module.len() => Some([&module[..module.len() - above], &path[above..]].concat()),
        _ => None,
    }
}

/// A circle in a graph, if there is one: its members in order.
fn circle(edges: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn walk(
        at: &str,
        edges: &BTreeMap<String, BTreeSet<String>>,
        way: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> Option<Vec<String>> {
        if let Some(start) = way.iter().position(|other| other == at) {
            return Some(way[start..].to_vec());
        }
        if done.contains(at) {
            return None;
        }
        way.push(at.to_string());
        let found = edges.get(at).into_iter().flatten().find_map(|next| walk(next, edges, way, done));
        way.pop();
        done.insert(at.to_string());
        found
    }
    let mut done = BTreeSet::new();
    edges.keys().find_map(|start| walk(start, edges, &mut Vec::new(), &mut done))
}

#[test]
fn a_folder_uses_only_what_is_below_it() {
    let floor_of = |module: &Module| {
        let name = module.first()?;
        let floor = FLOORS.iter().position(|floor| floor.contains(&name.as_str()));
        Some((name.clone(), floor.unwrap_or_else(|| panic!("src/{name} is on no floor: amend FLOORS"))))
    };
    let mut upwards = BTreeSet::new();
    for (from, to) in Modules::of(&repository("src")).edges() {
        let (Some((a, floor)), Some((b, below))) = (floor_of(&from), floor_of(&to)) else { continue };
        if a != b && below >= floor {
            upwards.insert(format!("{} uses {}", from.join("::"), to.join("::")));
        }
    }
    assert!(upwards.is_empty(), "{upwards:#?}");
}

/// Folders in which siblings still use each other in a circle: none may be added, and one that is mended is taken off.
const CIRCULAR: [&str; 9] = [
    "geometry",
    "interaction",
    "interaction::conversation",
    "interaction::conversation::grammar",
    "interaction::tasks",
    "senses",
    "session",
    "simulation",
    "skin::growing",
];

#[test]
fn within_a_folder_nothing_uses_itself_in_a_circle() {
    let modules = Modules::of(&repository("src"));
    let mut siblings: BTreeMap<Module, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (from, to) in modules.edges() {
        let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
        // Parents and their children know each other.
        if common > 0 && common < from.len() && common < to.len() {
            let folder = siblings.entry(from[..common].to_vec()).or_default();
            folder.entry(from[common].clone()).or_default().insert(to[common].clone());
        }
    }
    let circles: Vec<(String, Vec<String>)> =
        siblings.iter().filter_map(|(folder, edges)| Some((folder.join("::"), circle(edges)?))).collect();
    let folders: Vec<&str> = circles.iter().map(|(folder, _)| folder.as_str()).collect();
    assert_eq!(folders, CIRCULAR, "{circles:#?}");
}

/// "To add a request, write a file and name it in the table": nothing else names the ones that there are.
#[test]
fn a_request_is_a_file_and_a_line() {
    let conversation = repository("src/interaction/conversation");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let files = |folder: &str| {
        let entries = std::fs::read_dir(conversation.join(folder)).unwrap();
        entries.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some())
    };
    let sources: Vec<String> =
        ["", "grammar", "requests"].iter().flat_map(|folder| files(folder)).map(|path| read(&path)).collect();
    let mut requests = 0;
    for path in files("requests") {
        let module = path.file_stem().unwrap().to_string_lossy().into_owned();
        for line in read(&path).lines() {
            let request =
                line.strip_prefix("pub(super) const ").and_then(|rest| rest.split_once(": RequestKind"));
            let Some((name, _)) = request else { continue };
            let named: usize =
                sources.iter().map(|source| source.matches(&format!("{module}::{name}")).count()).sum();
            assert_eq!(named, 1, "{module}::{name}");
            requests += 1;
        }
    }
    assert!(requests > 30, "{requests}");
}
