//! Surfaces: faces of elements, or nodes.

use super::importer::Importer;
use super::kinds::{self, Family};
use super::scopes::At;
use retune::deck::DeckError;
use retune::linalg::vector3::{cross, dot, minus};
use std::collections::{BTreeMap, HashMap};

/// A face of an element, or an edge of a shell.
#[derive(Debug, Clone)]
pub(super) struct Face {
    /// The element.
    pub of: At,
    /// Corners in order, then the middle nodes of the edges of a quadratic face.
    pub nodes: Vec<At>,
    pub corners: usize,
    pub is_shell: bool,
}

#[derive(Debug, Clone)]
pub(super) enum Surface {
    Faces(Vec<Face>),
    /// Nodes with their weights.
    Nodes(Vec<(At, f64)>),
}

impl Importer<'_> {
    fn face(&self, at: At, corners: &[usize]) -> Face {
        let (kind, nodes) = (self.kind(at), self.nodes_of(at));
        let mut all: Vec<At> = corners.iter().map(|i| nodes[*i]).collect();
        all.extend(kinds::middles(kind, corners).into_iter().map(|i| nodes[i]));
        Face { of: at, nodes: all, corners: corners.len(), is_shell: kind.family == Family::Shell }
    }

    /// The surface of this name, seen from an instance.
    pub(super) fn surface(&self, instance: u32, name: &str) -> Result<Surface, String> {
        let (instance, keywords) = self.all.surface(instance, name)?;
        let mut faces = Vec::new();
        let mut nodes = Vec::new();
        for index in keywords {
            let k = self.deck.keyword(*index);
            self.surface_of(instance, &k, &mut faces, &mut nodes).map_err(|e| e.to_string())?;
        }
        if faces.is_empty() && nodes.is_empty() {
            return Err(format!("the surface `{name}` is empty"));
        }
        if !faces.is_empty() && !nodes.is_empty() {
            return Err(format!("the surface `{name}` is made of faces and of nodes; give one of them"));
        }
        Ok(if faces.is_empty() { Surface::Nodes(nodes) } else { Surface::Faces(faces) })
    }

    fn surface_of(
        &self,
        instance: u32,
        k: &retune::deck::Keyword<'_>,
        faces: &mut Vec<Face>,
        nodes: &mut Vec<(At, f64)>,
    ) -> Result<(), DeckError> {
        let kind = k.label("TYPE").unwrap_or_else(|| "ELEMENT".to_string());
        if let Some(p) = ["COMBINE", "CROP", "REGIONTYPE"].into_iter().find(|p| k.parameter(p).is_some()) {
            return Err(k.error(format_args!("surfaces made by {p} are not read; give elements and faces")));
        }
        match kind.as_str() {
            "NODE" => {
                for line in k.lines().filter(|l| !l.is_empty()) {
                    let found =
                        self.all.nodes(instance, line.text(0)).map_err(|m| line.error(Some((0, "nodes")), m))?;
                    let weight = line.real_or(1, "weight", 1.0)?;
                    nodes.extend(found.into_iter().map(|n| (n, weight)));
                }
                Ok(())
            }
            "ELEMENT" => {
                for line in k.lines().filter(|l| !l.is_empty()) {
                    let found =
                        self.all.elements(instance, line.text(0)).map_err(|m| line.error(Some((0, "elements")), m))?;
                    let face = retune::deck::label(line.text(1));
                    if face.is_empty() {
                        self.free_faces(&found, faces);
                        continue;
                    }
                    for at in found {
                        let kind = self.kind(at);
                        let number = || face.get(1..).and_then(|n| n.parse::<usize>().ok());
                        let corners = match face.as_str() {
                            "SPOS" | "SNEG" => {
                                kinds::face(kind, 1).filter(|_| kind.family == Family::Shell).map(<[usize]>::to_vec)
                            }
                            f if f.starts_with('S') => {
                                number().and_then(|n| kinds::face(kind, n)).map(<[usize]>::to_vec)
                            }
                            f if f.starts_with('E') => number().and_then(|n| edge(kind, n)),
                            _ => None,
                        };
                        let Some(corners) = corners else {
                            let text = format!("`{face}` is not a face of a {}", kind.name);
                            return Err(line.error(Some((1, "face")), text));
                        };
                        faces.push(self.face(at, &corners));
                    }
                }
                Ok(())
            }
            other => Err(k.error(format_args!("surfaces of the type {other} are not read; ELEMENT and NODE are"))),
        }
    }

    /// Faces that belong to one element only, and shells themselves.
    fn free_faces(&self, elements: &[At], faces: &mut Vec<Face>) {
        let mut seen: BTreeMap<Vec<At>, (usize, Face)> = BTreeMap::new();
        for at in elements {
            let kind = self.kind(*at);
            let count = if kind.family == Family::Shell { 1 } else { kinds::n_faces(kind) };
            for n in 1..=count {
                let Some(corners) = kinds::face(kind, n) else { continue };
                let face = self.face(*at, corners);
                let mut key = face.nodes[..face.corners].to_vec();
                key.sort_unstable();
                seen.entry(key).or_insert((0, face)).0 += 1;
            }
        }
        faces.extend(seen.into_values().filter(|f| f.0 == 1).map(|f| f.1));
    }

    /// Nodes of a surface with their shares: of faces by their areas, of nodes by their weights.
    pub(super) fn shares(&self, surface: &Surface) -> Vec<(At, f64)> {
        let faces = match surface {
            Surface::Nodes(nodes) => return nodes.clone(),
            Surface::Faces(faces) => faces,
        };
        let mut order = Vec::new();
        let mut shares: HashMap<At, f64> = HashMap::new();
        for face in faces {
            let p: Vec<[f64; 3]> = face.nodes.iter().map(|n| self.position(*n)).collect();
            let size = match face.corners {
                2 => 2.0 * dot(minus(p[1], p[0]), minus(p[1], p[0])).sqrt(),
                3 => norm(cross(minus(p[1], p[0]), minus(p[2], p[0]))),
                _ => norm(cross(minus(p[2], p[0]), minus(p[3], p[1]))),
            } * 0.5;
            // A quadratic face carries by its middles: exactly so on triangles, and by the scaled diagonal of its mass on quadrilaterals.
            let (corner, middle) = match (face.corners, face.nodes.len()) {
                (3, 6) => (0.0, 1.0 / 3.0),
                (4, 8) => (3.0 / 76.0, 16.0 / 76.0),
                (2, 3) => (1.0 / 6.0, 4.0 / 6.0),
                (n, _) => (1.0 / n as f64, 0.0),
            };
            for (i, node) in face.nodes.iter().enumerate() {
                let share = size * if i < face.corners { corner } else { middle };
                *shares.entry(*node).or_insert_with(|| {
                    order.push(*node);
                    0.0
                }) += share;
            }
        }
        order.into_iter().map(|n| (n, shares[&n])).collect()
    }
}

fn norm(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// An edge of a shell by its number, as indices of its corners.
fn edge(kind: &kinds::Kind, number: usize) -> Option<Vec<usize>> {
    let corners = match (kind.family, kind.nodes) {
        (Family::Shell, 3 | 6) => 3,
        (Family::Shell, 4 | 8) => 4,
        _ => return None,
    };
    (1..=corners).contains(&number).then(|| vec![number - 1, number % corners])
}
