//! Masses on grids.

use super::importer::{Importer, Space, Values};
use super::springs::{between, ends, frame_of_grid, put_nested};
use super::{CardRule, read, refused, used};
use crate::system::Quantity as Q;
use crate::text::map;
use crate::writer::Block;
use retune::deck::{Card, DeckError};
use retune::element::Dof;
use retune::linalg::vector3::minus;

pub(super) const CARDS: &[CardRule] = &[
    read("CONM2", "masses", conm2).up_to(15),
    read("CONM1", "masses", conm1),
    read("CMASS1", "masses", cmass).up_to(7),
    read("CMASS2", "masses", cmass).up_to(7),
    read("CMASS3", "masses", cmass).up_to(5),
    read("CMASS4", "masses", cmass).up_to(5),
    used("PMASS", "masses"),
    refused("NSM", "non-structural mass by sets is not read; give it on the properties"),
    refused("NSM1", "non-structural mass by sets is not read; give it on the properties"),
    refused("NSML", "non-structural mass by sets is not read; give it on the properties"),
    refused("NSML1", "non-structural mass by sets is not read; give it on the properties"),
    refused("NSMADD", "non-structural mass by sets is not read; give it on the properties"),
];

fn conm2<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let (node, grid) = importer.grid(card, 3, "G")?;
    let cid = card.integer_or(4, "CID", 0)?;
    let mass = card.real_or(5, "M", 0.0)?;
    if mass < 0.0 {
        return Err(card.error(Some((5, "M")), "a negative mass is not read"));
    }
    let mut values = Values::default();
    values.items.push(("node".into(), node));
    importer.put(&mut values, ("mass", "mass"), (card, 5, "M"), mass, (Q::Mass, importer.wtmass));
    let offset = card.vector(6, "X1")?;
    let mut frame = None;
    if cid == -1 {
        // The field has the basic coordinates of the centre of gravity.
        let arm = minus(offset, grid.position);
        values.items.push(("offset".into(), importer.lengths(arm)));
    } else {
        let (id, coord) = importer.coord(card, 4, "CID")?;
        frame = importer.frame(id, &coord, grid.position);
        if offset != [0.0; 3] {
            let mut parts = Vec::new();
            for (i, (axis, name)) in ["x", "y", "z"].iter().zip(["X1", "X2", "X3"]).enumerate() {
                let property = format!("offset_{axis}");
                importer.put(&mut values, ("", &property), (card, 6 + i, name), offset[i], (Q::Length, 1.0));
                parts.extend(values.items.pop().map(|p| p.1));
            }
            values.items.push(("offset".into(), format!("[{}]", parts.join(", "))));
        }
    }
    const INERTIA: [(&str, &str, f64); 6] = [
        ("xx", "I11", 1.0),
        ("xy", "I21", 1.0),
        ("yy", "I22", 1.0),
        ("xz", "I31", 1.0),
        ("yz", "I32", 1.0),
        ("zz", "I33", 1.0),
    ];
    let mut inertia = Vec::new();
    for (i, (axis, name, sign)) in INERTIA.into_iter().enumerate() {
        let value = card.real_or(10 + i, name, 0.0)?;
        if value != 0.0 {
            let of = (Q::Inertia, sign * importer.wtmass);
            importer.put(&mut values, (axis, &format!("inertia_{axis}")), (card, 10 + i, name), value, of);
            inertia.extend(values.items.pop());
        }
    }
    if !inertia.is_empty() {
        values.items.push(("inertia".into(), map(&inertia)));
    }
    values.items.extend(frame.map(|f| ("frame".to_string(), f)));
    importer.element(Block::Masses, card, values, None, None).map(|_| ())
}

/// Property of an entry of a mass matrix, row not above column.
fn entry(i: usize, j: usize) -> (String, Q) {
    let (a, b) = (i.min(j), i.max(j));
    let quantity = match (a >= 3, b >= 3) {
        (false, false) => Q::Mass,
        (true, true) => Q::Inertia,
        _ => Q::MassMoment,
    };
    (format!("m_{}_{}", Dof::ALL[a], Dof::ALL[b]), quantity)
}

fn matrix<'a>(
    importer: &mut Importer<'a>,
    card: &Card<'a>,
    node: &str,
    mut values: Values,
    property: Option<&Card<'a>>,
    frame: Option<String>,
) -> Result<(), DeckError> {
    let properties = map(&std::mem::take(&mut values.items));
    values.items.push(("type".into(), "mass_matrix".into()));
    values.items.push(("nodes".into(), format!("[{node}]")));
    values.items.push(("properties".into(), properties));
    values.items.extend(frame.map(|f| ("frame".to_string(), f)));
    importer.element(Block::Elements, card, values, property, None).map(|_| ())
}

fn conm1<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let (node, grid) = importer.grid(card, 3, "G")?;
    let (id, coord) = importer.coord(card, 4, "CID")?;
    let mut values = Values::default();
    let mut field = 5;
    for i in 0..6 {
        for j in 0..=i {
            let value = card.real_or(field, "M", 0.0)?;
            if value != 0.0 {
                let (name, quantity) = entry(i, j);
                importer.put(&mut values, (&name, &name), (card, field, "M"), value, (quantity, importer.wtmass));
            }
            field += 1;
        }
    }
    if values.items.is_empty() {
        return Err(card.error(Some((5, "M11")), "its matrix is empty"));
    }
    let frame = importer.frame(id, &coord, grid.position);
    matrix(importer, card, &node, values, None, frame)
}

fn cmass<'a>(importer: &mut Importer<'a>, card: &Card<'a>) -> Result<(), DeckError> {
    let (property, source, field) = if matches!(card.name(), "CMASS1" | "CMASS3") {
        let pid = card.optional_id(3, "PID")?.map_or_else(|| card.id_at(2, "EID"), Ok)?;
        let found = importer.find(Space::PointMass, pid);
        let found = found.ok_or_else(|| card.error(Some((3, "PID")), format_args!("there is no PMASS {pid}")))?;
        let mut first = 2;
        for n in [2, 4, 6, 8] {
            if found.optional_id(n, "PID")? == Some(pid) {
                first = n;
            }
        }
        (Some(found.clone()), found, first + 1)
    } else {
        (None, card.clone(), 3)
    };
    let mass = source.real_or(field, "M", 0.0)?;
    if mass < 0.0 {
        return Err(source.error(Some((field, "M")), "a negative mass is not read"));
    }
    let places = ends(card);
    let end = match (importer.end(card, places[0], "G1")?, importer.end(card, places[1], "G2")?) {
        (Some(end), None) | (None, Some(end)) => end,
        (None, None) => return Err(card.error(Some((4, "G1")), "a mass needs a grid or a scalar point")),
        // It couples their accelerations: force by the difference of both.
        (Some(one), Some(second)) => {
            let mut values = Values::default();
            let of = (Q::Mass, importer.wtmass);
            let m = put_nested(importer, &mut values, ("m", "m"), (&source, field, "M"), mass, of);
            return between(importer, card, values, m, [&one, &second], property.as_ref());
        }
    };
    let component = end.component;
    let (name, quantity) = entry(component, component);
    let mut values = Values::default();
    importer.put(&mut values, (&name, &name), (&source, field, "M"), mass, (quantity, importer.wtmass));
    let frame = end.grid.and_then(|grid| frame_of_grid(importer, &end.node, &grid));
    matrix(importer, card, &end.node, values, property.as_ref(), frame)
}
