//! The mesh that a model file names: read, in m, its nodes by name, and its sets in the lists of the file.

use super::geometry::Geometry;
use super::loaded_mesh::{ALL, LoadedMesh, PlacedMesh};
use super::spec::{ModelSpec, NodeRule, NodeSpec};
use crate::catalogue::did_you_mean;
use crate::hash::sha256;
use crate::mesh::{self, Mesh};
use crate::units::Scalar;
use crate::yaml::{Problem, child};
use std::collections::HashMap;
use std::io;
use std::sync::Arc;

/// Reads the mesh of a model.
///
/// * `read` - the bytes of a file by its path in the model file
///
/// Returns what was wrong.
pub(super) fn read_file(spec: &mut ModelSpec, read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(loaded) = load(spec, read, &mut problems)
        && let Some(entry) = &mut spec.mesh
    {
        entry.loaded = LoadedMesh(Some(Arc::new(loaded)));
    }
    problems
}

fn load(
    spec: &ModelSpec,
    read: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
    problems: &mut Vec<Problem>,
) -> Option<PlacedMesh> {
    let entry = spec.mesh.as_ref()?;
    let mut wrong = |key: &str, message: String| problems.push(Problem::error(child("mesh", key), message));
    let Ok(unit) = Scalar::parse(&format!("1 {}", entry.units)).and_then(|s| s.constant_in("m")) else {
        let text =
            format!("`{}` is not a unit of length; the coordinates of the mesh are in `m`, `mm`, `in`, …", entry.units);
        wrong("units", text);
        return None;
    };
    let bytes = match read(&entry.file) {
        Ok(bytes) => bytes,
        Err(e) => {
            wrong("file", format!("it cannot be read: {e}"));
            return None;
        }
    };
    if let Some(expected) = &entry.sha256 {
        let found = sha256(&bytes);
        if !found.eq_ignore_ascii_case(expected) {
            let text = format!("`{}` is another file than the model was made for: its hash is {found}", entry.file);
            wrong("sha256", text);
            return None;
        }
    }
    let mut mesh = match mesh::read(&bytes) {
        Ok(mesh) => mesh,
        Err(e) => {
            wrong("file", format!("`{}`: {e}", entry.file));
            return None;
        }
    };
    mesh.nodes.iter_mut().for_each(|n| n.at = n.at.map(|x| x * unit));
    let mut named: Vec<(String, usize)> = Vec::new();
    for (name, node) in &spec.nodes {
        let NodeSpec::Rule(rule) = node else { continue };
        let path = child("nodes", name);
        let Some(index) = meant(rule, &mesh, &path, problems) else { continue };
        if let Some((other, _)) = named.iter().find(|(_, i)| *i == index) {
            let id = mesh.nodes[index].id;
            problems
                .push(Problem::error(path, format_args!("`{other}` and `{name}` are the same node of the mesh, {id}")));
        }
        named.push((name.clone(), index));
    }
    let mut prefixes: Vec<(String, u64)> = entry.prefixes.iter().map(|(p, offset)| (p.clone(), *offset)).collect();
    prefixes.sort_by_key(|p| p.1);
    if prefixes.is_empty() {
        prefixes.push(("n".to_string(), 0));
    }
    problems.is_empty().then_some(PlacedMesh { mesh, named, prefixes })
}

/// The node of the mesh that a rule means, where it means one.
fn meant(rule: &NodeRule, mesh: &Mesh, path: &str, problems: &mut Vec<Problem>) -> Option<usize> {
    if let Some(label) = &rule.mesh {
        let found = label.0.parse().ok().and_then(|id| mesh.node(id));
        if found.is_none() {
            problems.push(Problem::error(child(path, "mesh"), format_args!("the mesh has no node {}", label.0)));
        }
        return found;
    }
    let place = rule.nearest.as_ref()?;
    let at = super::geometry::vector(place, "m", &child(path, "nearest"), problems);
    let distance = |i: &usize| (0..3).map(|k| (mesh.nodes[*i].at[k] - at[k]).powi(2)).sum::<f64>();
    let mut used = vec![false; mesh.nodes.len()];
    (0..mesh.cells.len()).flat_map(|c| mesh.nodes_of(c)).for_each(|&n| used[n] = true);
    (0..mesh.nodes.len()).filter(|&i| used[i]).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Puts the nodes of sets into the lists that name them, where the mesh was read; what has its nodes already stays as it is.
pub(super) fn name_nodes(spec: &mut ModelSpec) {
    if let Some(loaded) = spec.mesh.as_ref().and_then(|m| m.loaded.0.clone()) {
        expand(spec, &loaded);
    }
}

/// The set of the mesh that consists of just these nodes of the model.
pub(super) fn set_of<'s>(spec: &'s ModelSpec, geometry: &Geometry, nodes: &[usize]) -> Option<&'s str> {
    let loaded = spec.mesh.as_ref()?.loaded.0.as_ref()?;
    let mut wanted = nodes.to_vec();
    wanted.sort_unstable();
    let is_it = |set: &&mesh::MeshSet| {
        let own: Option<Vec<usize>> =
            loaded.mesh.nodes_of_set(set).into_iter().map(|n| geometry.node(&loaded.name(n))).collect();
        own.is_some_and(|mut own| {
            own.sort_unstable();
            own == wanted
        })
    };
    loaded.mesh.sets.iter().find(is_it).map(|s| s.name.as_str())
}

/// Puts the nodes of sets into the lists of the file that name the sets, and gives nodes of two names the one of the file.
fn expand(spec: &mut ModelSpec, loaded: &PlacedMesh) {
    let own: HashMap<usize, &str> = loaded.named.iter().map(|(name, i)| (*i, name.as_str())).collect();
    let name_of = |i: usize| own.get(&i).map_or_else(|| loaded.name(i), |name| (*name).to_string());
    let known: std::collections::HashSet<String> = spec.nodes.keys().cloned().collect();
    let single = |name: &mut String| {
        if !known.contains(name.as_str())
            && let Some(i) = loaded.node(name)
        {
            *name = name_of(i);
        }
    };
    let several = |names: &mut Vec<String>| {
        let mut out = Vec::with_capacity(names.len());
        for mut name in std::mem::take(names) {
            match loaded.mesh.set(&name).filter(|_| !known.contains(&name)) {
                Some(set) => out.extend(loaded.mesh.nodes_of_set(set).into_iter().map(name_of)),
                None => {
                    single(&mut name);
                    out.push(name);
                }
            }
        }
        *names = out;
    };
    // One set as the `node` of a support or a mass is several nodes.
    let either = |node: &mut Option<String>, nodes: &mut Option<Vec<String>>| {
        if let Some(name) = node.as_mut() {
            if !known.contains(name.as_str()) && loaded.mesh.set(name).is_some() && nodes.is_none() {
                *nodes = Some(vec![std::mem::take(name)]);
                *node = None;
            } else {
                single(name);
            }
        }
        if let Some(nodes) = nodes {
            several(nodes);
        }
    };
    let configurations = spec.configurations.values_mut().flat_map(|c| c.supports.values_mut());
    for support in spec.supports.values_mut().chain(configurations) {
        either(&mut support.node, &mut support.nodes);
    }
    let configurations = spec.configurations.values_mut().flat_map(|c| c.masses.values_mut());
    for mass in spec.masses.values_mut().chain(configurations) {
        either(&mut mass.node, &mut mass.nodes);
    }
    for force in spec.preloads.values_mut().flat_map(|p| p.forces.values_mut()) {
        several(&mut force.nodes);
    }
    for link in spec.rigid_links.values_mut() {
        single(&mut link.master);
        several(&mut link.slaves);
        link.slaves.retain(|s| *s != link.master);
    }
    for tie in spec.ties.values_mut() {
        several(&mut tie.nodes);
    }
    for link in spec.weighted_links.values_mut() {
        single(&mut link.node);
        for set in &mut link.of {
            several(&mut set.nodes);
            set.nodes.retain(|n| *n != link.node);
        }
    }
}

/// Refuses a mesh whose file was not read, and parts of sets that it does not have.
pub(super) fn check(spec: &ModelSpec, problems: &mut Vec<Problem>) {
    let Some(entry) = &spec.mesh else {
        for (name, node) in &spec.nodes {
            if let NodeSpec::Rule(rule) = node
                && (rule.mesh.is_some() || rule.nearest.is_some())
            {
                let text = "a node of a mesh needs one: `mesh: {file: wing.msh, units: mm, parts: {…}}` at the top of the file";
                problems.push(Problem::error(child("nodes", name), text));
            }
        }
        return;
    };
    let Some(loaded) = &entry.loaded.0 else {
        let said = problems.iter().any(|p| p.path.starts_with("mesh"));
        if !said {
            let text = "its file was not read: a model with a mesh is loaded from its file, or by `load_in`";
            problems.push(Problem::error("mesh.file", text));
        }
        return;
    };
    let sets = || loaded.mesh.sets.iter().map(|s| s.name.as_str());
    let known: Vec<String> = sets().map(|n| format!("`{n}`")).collect();
    let known = if known.is_empty() {
        "it has none; `all` is every cell".to_string()
    } else {
        format!("it has {}", known.join(", "))
    };
    for name in entry.parts.keys().filter(|n| *n != ALL && loaded.mesh.set(n).is_none()) {
        let suggestion = did_you_mean(name, sets().chain([ALL]));
        let path = child("mesh.parts", name);
        problems.push(Problem::error(path, format_args!("the mesh has no set `{name}`{suggestion} ({known})")));
    }
    if entry.parts.is_empty() {
        let text = format!("say what stands on the sets of the mesh, `parts: {{all: {{section: skin}}}}` ({known})");
        problems.push(Problem::error("mesh.parts", text));
    }
}
