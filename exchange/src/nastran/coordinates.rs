//! Grid points and coordinate systems.

use super::importer::{Grid, Importer, Space, node};
use super::{CardRule, left_out, read, refused, used};
use crate::coord::{Coord, GLOBAL_COORD, Kind};
use crate::motions::Placed;
use crate::system::Quantity;
use crate::text::{exact, with_unit};
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::linalg::vector3::{cross, dot, minus, unit};

pub(super) const CARDS: &[CardRule] = &[
    read("GRID", "nodes", grid).up_to(9),
    used("GRDSET", "nodes"),
    used("CORD2R", "frames"),
    used("CORD2C", "frames"),
    used("CORD2S", "frames"),
    used("CORD1R", "frames"),
    used("CORD1C", "frames"),
    used("CORD1S", "frames"),
    refused("CORD3G", "general coordinate systems are not read; give a CORD2R"),
    left_out("EPOINT", "points of control systems, which have no stiffness and no mass"),
];

/// Coordinate systems that hang on each other, at most.
const DEEPEST: u32 = 200;

impl<'a> Importer<'a> {
    /// The coordinate system that a field names.
    pub(super) fn coord(
        &mut self,
        card: &Card<'_>,
        field: usize,
        name: &'static str,
    ) -> Result<(u32, Coord), DeckError> {
        let id = card.integer_or(field, name, 0)?;
        let id = u32::try_from(id)
            .map_err(|_| card.error(Some((field, name)), "a coordinate system has no negative number here"))?;
        self.coord_at(id, 0, (card, field, name)).map(|c| (id, c))
    }

    fn coord_at(
        &mut self,
        id: u32,
        depth: u32,
        (card, field, name): (&Card<'_>, usize, &'static str),
    ) -> Result<Coord, DeckError> {
        if let Some(known) = self.coords.get(&id) {
            return Ok(*known);
        }
        let at = Some((field, name));
        let own = self
            .find(Space::Coordinates, id)
            .ok_or_else(|| card.error(at, format_args!("there is no coordinate system {id}")))?;
        if depth > DEEPEST {
            return Err(own.error(None, "it depends on itself through other coordinate systems or grids"));
        }
        let kind = match own.name().chars().last() {
            Some('C') => Kind::Cylindrical,
            Some('S') => Kind::Spherical,
            _ => Kind::Rectangular,
        };
        let [a, b, c] = if own.name().starts_with("CORD1") {
            let first = if own.optional_id(2, "CID")? == Some(id) { 2 } else { 6 };
            let mut points = [[0.0; 3]; 3];
            for (i, point) in points.iter_mut().enumerate() {
                let grid = own.id_at(first + 1 + i, "G")?;
                *point = self.grid_at_of(grid, depth + 1, (&own, first + 1 + i, "G"))?.position;
            }
            points
        } else {
            let reference = own.integer_or(3, "RID", 0)?;
            let reference = u32::try_from(reference)
                .map_err(|_| own.error(Some((3, "RID")), "a number of a coordinate system is expected"))?;
            let base = self.coord_at(reference, depth + 1, (&own, 3, "RID"))?;
            [own.vector(4, "A")?, own.vector(7, "B")?, own.vector(10, "C")?].map(|p| base.to_basic(p))
        };
        let z = unit(minus(b, a)).ok_or_else(|| own.error(None, "its points A and B are one: it has no z axis"))?;
        let y = cross(z, minus(c, a));
        let size = dot(minus(c, a), minus(c, a)).sqrt();
        let y = unit(y).filter(|_| dot(y, y).sqrt() > 1e-9 * size);
        let y = y.ok_or_else(|| own.error(None, "its point C lies on its z axis: it has no x axis"))?;
        let coord = Coord { kind, origin: a, axes: [cross(y, z), y, z] };
        self.coords.insert(id, coord);
        Ok(coord)
    }

    /// Reads a grid ahead of its turn.
    pub(super) fn grid_at(&mut self, id: u32, depth: u32) -> Result<Grid, DeckError> {
        match self.find(Space::Grid, id) {
            Some(card) => self.grid_at_of(id, depth, (&card, 2, "ID")),
            None => unreachable!("only grids of the index are asked for"),
        }
    }

    fn grid_at_of(
        &mut self,
        id: u32,
        depth: u32,
        (from, field, name): (&Card<'_>, usize, &'static str),
    ) -> Result<Grid, DeckError> {
        if let Some(known) = self.known_grid(id) {
            return Ok(*known);
        }
        let card = self
            .find(Space::Grid, id)
            .ok_or_else(|| from.error(Some((field, name)), format_args!("there is no GRID {id}")))?;
        if depth > DEEPEST {
            return Err(card.error(None, "it depends on itself through coordinate systems"));
        }
        let default = self.default_of("GRDSET");
        let number = |n: usize, name| -> Result<u32, DeckError> {
            let source = if card.is_blank(n) { default.as_ref().unwrap_or(&card) } else { &card };
            let value = source.integer_or(n, name, 0)?;
            // -1 marks a point of fluid or a scalar point.
            u32::try_from(value).map_err(|_| source.error(Some((n, name)), "a negative coordinate system is not read"))
        };
        let (cp, cd) = (number(3, "CP")?, number(7, "CD")?);
        let base = self.coord_at(cp, depth + 1, (&card, 3, "CP"))?;
        let position = base.to_basic(card.vector(4, "X1")?);
        self.coord_at(cd, depth + 1, (&card, 7, "CD"))?;
        let grid = Grid { position, cd };
        self.add_grid(id, grid);
        Ok(grid)
    }

    /// The card that gives defaults to others: GRDSET, BAROR, BEAMOR.
    pub(super) fn default_of(&self, name: &str) -> Option<Card<'a>> {
        self.defaults.get(name).map(|c| self.deck.card(*c))
    }

    /// Directions of the displacements of a grid, as rows.
    pub(super) fn displacement_axes(&self, grid: &Grid) -> [[f64; 3]; 3] {
        self.coords.get(&grid.cd).map_or(GLOBAL_COORD.axes, |c| c.axes_at(grid.position))
    }

    /// Where a grid is and the directions of its displacements.
    pub(super) fn placed(&self, grid: &Grid) -> Placed {
        Placed { position: grid.position, axes: self.displacement_axes(grid) }
    }

    /// A component of a grid as dofs along global axes with their factors.
    pub(super) fn component(&self, grid: &Grid, component: usize) -> Vec<(Dof, f64)> {
        self.placed(grid).component(component)
    }

    /// Whether components of a grid are along global axes.
    pub(super) fn is_global(&self, grid: &Grid) -> bool {
        self.placed(grid).is_global()
    }

    /// The frame of a coordinate system at a point, written when it is first named; `None` for global axes.
    pub(super) fn frame(&mut self, id: u32, coord: &Coord, point: [f64; 3]) -> Option<String> {
        let axes = coord.axes_at(point);
        if axes == GLOBAL_COORD.axes && coord.origin == [0.0; 3] {
            return None;
        }
        if let Some(name) = self.frames.get(&id).filter(|_| coord.kind == Kind::Rectangular) {
            return Some(name.clone());
        }
        let plain = format!("cord_{id}");
        let name = self.names.unique(&plain);
        let is_rectangular = coord.kind == Kind::Rectangular;
        let origin = if is_rectangular { coord.origin } else { point };
        self.write_frame(&name, origin, axes);
        if is_rectangular {
            self.frames.insert(id, name.clone());
        }
        Some(name)
    }

    /// A frame of its own.
    pub(super) fn write_frame(&mut self, name: &str, origin: [f64; 3], axes: [[f64; 3]; 3]) {
        let unit = self.unit(Quantity::Length);
        let origin = origin.map(|x| with_unit(&exact(x), unit)).join(", ");
        let value = crate::text::frame(format!("[{origin}]"), axes);
        self.out.entry(Block::Frames, name, &value, "");
    }
}

fn grid(importer: &mut Importer<'_>, card: &Card<'_>) -> Result<(), DeckError> {
    let id = card.id_at(2, "ID")?;
    let name = node(id);
    let (_, own) = importer.grid_of(card, 2, "ID", id)?;
    if importer.origins.grids.insert(name.clone(), card.id()).is_some() {
        return Ok(()); // the same once more
    }
    let (cp, base) = importer.coord(card, 3, "CP")?;
    let unit = importer.unit(Quantity::Length);
    let length = |x: f64| with_unit(&exact(x), unit);
    let value = if cp == 0 {
        format!("[{}]", card.vector(4, "X1")?.map(length).join(", "))
    } else if base.kind == Kind::Rectangular {
        let at = card.vector(4, "X1")?.map(length).join(", ");
        match importer.frame(cp, &base, own.position) {
            Some(frame) => format!("{{frame: {frame}, at: [{at}]}}"),
            None => format!("[{at}]"),
        }
    } else {
        importer.lengths(own.position)
    };
    importer.comments(Block::Nodes);
    importer.out.node(&name, &value, Some(own.position), "");
    if let Some(frame) = super::springs::frame_of_grid(importer, &name, &own) {
        importer.turned.entry(frame).or_default().push(name.clone());
    }
    let default = importer.default_of("GRDSET");
    let source = if card.is_blank(8) { default.unwrap_or_else(|| card.clone()) } else { card.clone() };
    let held = source.components(8, "PS")?;
    if held.iter().any(|h| *h) {
        importer.hold(&format!("ps_{id}"), &[(name, own)], held);
    }
    Ok(())
}
