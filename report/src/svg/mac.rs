//! A MAC matrix with its values, the pairs framed.

use super::super::data::{LabelledMatrix, Pair};
use super::plot::{Canvas, INK, SOFT, TEXT};
use super::{COLUMN, cut};

/// Anchors of viridis at equal distances.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

fn viridis(t: f64) -> (String, &'static str) {
    if !t.is_finite() {
        return ("#eeeeee".into(), INK);
    }
    let place = t.clamp(0.0, 1.0) * 8.0;
    let i = (place.floor() as usize).min(7);
    let f = place - i as f64;
    let [r, g, b]: [f64; 3] = std::array::from_fn(|k| VIRIDIS[i][k] + (VIRIDIS[i + 1][k] - VIRIDIS[i][k]) * f);
    let hex = format!("#{:02x}{:02x}{:02x}", r.round() as u8, g.round() as u8, b.round() as u8);
    (hex, if t > 0.55 { INK } else { "#ffffff" })
}

/// Width of a letter on the average, of its size.
const LETTER: f64 = 0.52;

pub(super) fn mac(m: &LabelledMatrix, pairs: &[Pair]) -> Canvas {
    let (rows, columns) = (m.rows.len().max(1) as f64, m.columns.len().max(1) as f64);
    let longest = |names: &[String]| names.iter().map(|n| n.chars().count().min(26)).max().unwrap_or(0) as f64;
    // Room for the axis title, the names and, on the right, the colour bar.
    let left = 66.0 + LETTER * TEXT * longest(&m.rows);
    let right = 120.0;
    let width = COLUMN.max((left + right + 56.0 * columns) / 10.0);
    let cell = ((width * 10.0 - left - right) / columns).min(150.0);
    let size = (cell * 0.36).min(TEXT);
    let names = TEXT.min(cell * 0.6);
    let (slant, slope) = (60_f64.to_radians().sin(), 60_f64.to_radians().cos());
    let below = LETTER * names * longest(&m.columns);
    let left = left.max(below * slope - cell / 2.0 + 20.0);
    let top = 24.0;
    let bottom = top + cell * rows;
    let mut c = Canvas::new(width, (bottom + below * slant + 78.0) / 10.0);
    for (i, name) in m.rows.iter().enumerate() {
        let y = top + cell * (i as f64 + 0.5);
        c.text([left - 12.0, y + names * 0.35], &cut(name, 26), names, "end", INK, 0.0);
        for (j, v) in m.values.get(i).into_iter().flatten().enumerate() {
            let (fill, ink) = viridis(*v);
            let corner = [left + cell * j as f64, top + cell * i as f64];
            c.rect(corner, [cell, cell], &fill, "#ffffff");
            if size > 12.0 && v.is_finite() {
                let middle = [corner[0] + cell / 2.0, corner[1] + cell / 2.0 + size * 0.35];
                c.text(middle, &format!("{v:.2}"), size, "middle", ink, 0.0);
            }
        }
    }
    for p in pairs {
        if let (Some(i), Some(j)) = (p.model_mode, p.test_mode)
            && i < m.rows.len()
            && j < m.columns.len()
        {
            let corner = [left + cell * j as f64 + 3.0, top + cell * i as f64 + 3.0];
            c.frame(corner, [cell - 6.0, cell - 6.0], "#ffffff", 9.0);
            c.frame(corner, [cell - 6.0, cell - 6.0], INK, 5.0);
        }
    }
    for (j, name) in m.columns.iter().enumerate() {
        let x = left + cell * (j as f64 + 0.5) + names * 0.3;
        c.text([x, bottom + 20.0], &cut(name, 26), names, "end", INK, -60.0);
    }
    c.text([34.0, top + cell * rows / 2.0], &m.row_axis, TEXT, "middle", SOFT, -90.0);
    c.text([left + cell * columns / 2.0, bottom + below * slant + 60.0], &m.column_axis, TEXT, "middle", SOFT, 0.0);
    bar(&mut c, [left + cell * columns + 24.0, top], bottom - top);
    c
}

/// The colours from 0 to 1, upwards.
fn bar(c: &mut Canvas, [x, y]: [f64; 2], height: f64) {
    let steps = 48;
    let one = height / f64::from(steps);
    for k in 0..steps {
        let (fill, _) = viridis(1.0 - (f64::from(k) + 0.5) / f64::from(steps));
        // A little taller than the step: no white between neighbours where a reader smooths edges.
        c.rect([x, y + one * f64::from(k)], [20.0, one + if k + 1 < steps { 1.0 } else { 0.0 }], &fill, "none");
    }
    c.frame([x, y], [20.0, height], SOFT, 1.5);
    for (at, label) in [(0.0, "1"), (0.5, "0.5"), (1.0, "0")] {
        let at = (y + height * at + 9.0).clamp(y + 18.0, y + height);
        c.text([x + 28.0, at], label, TEXT - 2.0, "start", INK, 0.0);
    }
}
