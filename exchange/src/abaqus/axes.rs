//! Axes: orientations of materials and springs, and displacement axes of nodes.

use super::importer::{Importer, Solver, word};
use super::scopes::{At, axes};
use crate::coord::{Coord, Kind};
use crate::motions::Placed;
use crate::writer::Block;
use retune::deck::{DeckError, Keyword};
use retune::linalg::vector3::{minus, plus, unit};
use retune::model::GLOBAL;

/// An ORIENTATION as it stands in an instance.
#[derive(Debug, Clone)]
pub(super) struct Orientation {
    coord: Coord,
    /// The axis about which it turns, 1 to 3, and how far, rad.
    pub axis: usize,
    pub angle: f64,
    /// Its keyword and the instance, by which its frame is found again.
    pub keyword: usize,
    instance: u32,
}

impl Orientation {
    /// Its axes at a point, before the additional rotation.
    pub(super) fn axes_at(&self, point: [f64; 3]) -> [[f64; 3]; 3] {
        self.coord.axes_at(point)
    }

    /// Its axes at a point, turned about its axis.
    pub(super) fn turned_at(&self, point: [f64; 3]) -> [[f64; 3]; 3] {
        let mut axes = self.axes_at(point);
        let (p, q) = (self.axis % 3, (self.axis + 1) % 3);
        let (sin, cos) = self.angle.sin_cos();
        let (a, b) = (axes[p], axes[q]);
        axes[p] = plus(a.map(|v| v * cos), sin, b);
        axes[q] = plus(b.map(|v| v * cos), -sin, a);
        axes
    }

    /// The direction on a shell from which its material is turned by an angle about the normal, rad. For Abaqus the axis behind the one
    /// about which it turns, for CalculiX its own first axis.
    pub(super) fn on_shell(&self, point: [f64; 3], solver: Solver) -> ([f64; 3], f64) {
        match solver {
            Solver::Abaqus => (self.axes_at(point)[self.axis % 3], self.angle),
            Solver::CalculiX => (self.turned_at(point)[0], 0.0),
        }
    }

    fn is_rectangular(&self) -> bool {
        self.coord.kind == Kind::Rectangular
    }
}

/// A cylindrical system about the line through two points.
fn about(a: [f64; 3], b: [f64; 3]) -> Option<Coord> {
    let z = unit(minus(b, a))?;
    let i = (0..3).min_by(|i, j| z[*i].abs().total_cmp(&z[*j].abs())).unwrap_or(0);
    let [z, x, y] = axes(z, GLOBAL[i])?;
    Some(Coord { kind: Kind::Cylindrical, origin: a, axes: [x, y, z] })
}

impl Importer<'_> {
    /// The orientation of this name, seen from an instance.
    pub(super) fn orientation(&self, from: &Keyword<'_>, instance: u32, name: &str) -> Result<Orientation, DeckError> {
        // A part may use the model's.
        let own = self.all.body(instance).orientations.get(name).map(|k| (*k, instance));
        let found = own.or_else(|| self.all.body(0).orientations.get(name).map(|k| (*k, 0)));
        let Some((index, instance)) = found else {
            let known = self.all.body(instance).orientations.keys().map(String::as_str);
            let suggestion = retune::catalogue::did_you_mean(name, known);
            return Err(from.error(format_args!("there is no orientation `{name}`{suggestion}")));
        };
        let k = self.deck.keyword(index);
        let definition = k.label("DEFINITION").unwrap_or_else(|| "COORDINATES".to_string());
        let kind = k.label("SYSTEM").unwrap_or_else(|| "RECTANGULAR".to_string());
        if definition != "COORDINATES" || !matches!(kind.as_str(), "RECTANGULAR" | "CYLINDRICAL") {
            return Err(k.error(
                "orientations are read with SYSTEM=RECTANGULAR or CYLINDRICAL and DEFINITION=COORDINATES; give one of these",
            ));
        }
        let line = k.needs_line(0, "the points a and b")?;
        let (a, b) = (line.vector(0, "a")?, line.vector(3, "b")?);
        let wrong = || line.error(Some((3, "b")), "its points give no axes: they lie on one line");
        let coord = if kind == "RECTANGULAR" {
            let origin = line.vector(6, "c")?;
            let axes = axes(minus(a, origin), minus(b, origin)).ok_or_else(wrong)?;
            Coord { kind: Kind::Rectangular, origin, axes }
        } else {
            about(a, b).ok_or_else(wrong)?
        };
        let (mut axis, mut angle) = (1, 0.0);
        if let Some(line) = k.line(1).filter(|l| !l.is_empty()) {
            axis = line.id(0, "axis")? as usize;
            if axis > 3 {
                return Err(line.error(Some((0, "axis")), "1, 2 or 3 is expected"));
            }
            angle = line.real_or(1, "angle", 0.0)?.to_radians();
        }
        let place = &self.all.instances[instance as usize];
        let coord = Coord { origin: place.place(coord.origin), axes: coord.axes.map(|v| place.turn(v)), ..coord };
        Ok(Orientation { coord, axis, angle, keyword: index, instance })
    }

    /// The frame of an orientation at a point.
    pub(super) fn frame_at(&mut self, o: &Orientation, point: [f64; 3]) -> String {
        let key = (o.keyword, o.instance);
        if let Some(name) = self.frames.get(&key).filter(|_| o.is_rectangular()) {
            return name.clone();
        }
        let name = self.deck.keyword(o.keyword).label("NAME").unwrap_or_default();
        let name = word(&name, "orientation");
        let name = self.frame_names.unique(&name);
        let origin = if o.is_rectangular() { o.coord.origin } else { point };
        self.write_frame(&name, origin, o.turned_at(point));
        self.frames.insert(key, name.clone());
        name
    }

    fn write_frame(&mut self, name: &str, origin: [f64; 3], axes: [[f64; 3]; 3]) {
        let value = crate::text::frame(self.lengths(origin), axes);
        self.out.entry(Block::Frames, name, &value, "");
    }

    /// Reads TRANSFORM: displacement axes of nodes.
    pub(super) fn transform(&mut self, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
        let line = k.needs_line(0, "the points a and b")?;
        let (a, b) = (line.vector(0, "a")?, line.vector(3, "b")?);
        let wrong = || line.error(Some((3, "b")), "its points give no axes: they lie on one line");
        let coord = match k.label("TYPE").as_deref() {
            None | Some("R") => {
                Coord { kind: Kind::Rectangular, origin: [0.0; 3], axes: axes(a, b).ok_or_else(wrong)? }
            }
            Some("C") => about(a, b).ok_or_else(wrong)?,
            Some(_) => return Err(k.error("spherical displacement axes (TYPE=S) are not read; give R or C")),
        };
        let place = self.all.instances[instance as usize].clone();
        let coord = Coord { origin: place.place(coord.origin), axes: coord.axes.map(|v| place.turn(v)), ..coord };
        let nodes = self.all.nodes(instance, &k.needs("NSET")?).map_err(|m| k.error(m))?;
        for node in nodes {
            let axes = coord.axes_at(self.position(node));
            self.transforms.insert(node, axes);
        }
        Ok(())
    }

    /// A node with the axes of its displacements.
    pub(super) fn placed(&self, node: At) -> Placed {
        let axes = self.transforms.get(&node).copied().unwrap_or(GLOBAL);
        Placed { position: self.position(node), axes }
    }

    /// The frame of the displacement axes of a node; none where they are global.
    pub(super) fn frame_of_node(&mut self, node: At) -> Option<String> {
        let placed = self.placed(node);
        if placed.is_global() {
            return None;
        }
        if let Some(name) = self.node_frames.get(&node) {
            return Some(name.clone());
        }
        let name = self.frame_names.unique(&format!("axes_{}", self.node_name(node)));
        self.write_frame(&name, placed.position, placed.axes);
        self.node_frames.insert(node, name.clone());
        Some(name)
    }
}
