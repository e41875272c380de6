//! The lowest 20 modes of a free-free grillage of N x N nodes, three dofs each, and what they cost.
//!
//! ```sh
//! cargo run --release -p retune-linalg --example sparse_grillage -- 183
//! ```
//!
//! 58, 183 and 578 nodes a side give 10⁴, 10⁵ and 10⁶ dofs. With a folder as second argument, the matrices and the
//! values are written there for `benches/peers/sparse_slepc.py`. `--no-count` leaves out the count of modes.

use nalgebra::{DMatrix, SymmetricEigen};
use retune_linalg::sparse::{SparseOptions, SparsePlan, SparseSym, backward_error, lowest_sparse_modes};
use std::io::Write;
use std::time::Instant;

/// Grid beam of the dofs (w, θx, θy) at each end, along x or y: bending and torsion, consistent mass, torsional inertia.
fn beam(along_x: bool, length: f64, stiffness: f64) -> ([[f64; 6]; 6], [[f64; 6]; 6]) {
    let (ei, gj, mass, inertia) = (70.0 * stiffness, 50.0 * stiffness, 1.0, 2e-4);
    // Local: deflection, slope dw/ds, twist about s. Along x: slope = -θy, twist = θx; along y: slope = θx, twist = θy.
    let (slope, twist, sign) = if along_x { (2, 1, -1.0) } else { (1, 2, 1.0) };
    let (l, l2) = (length, length * length);
    let c = ei / (l * l2);
    let kb = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l2, -6.0 * l, 2.0 * l2],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l2, -6.0 * l, 4.0 * l2],
    ];
    let mb = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l2, 13.0 * l, -3.0 * l2],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l2, -22.0 * l, 4.0 * l2],
    ];
    let place = [(0, 1.0), (slope, sign), (3, 1.0), (3 + slope, sign)];
    let (mut k, mut m) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for (i, (a, sa)) in place.iter().enumerate() {
        for (j, (b, sb)) in place.iter().enumerate() {
            k[*a][*b] += c * kb[i][j] * sa * sb;
            m[*a][*b] += mass * l / 420.0 * mb[i][j] * sa * sb;
        }
    }
    for (i, a) in [twist, 3 + twist].into_iter().enumerate() {
        for (j, b) in [twist, 3 + twist].into_iter().enumerate() {
            k[a][b] += gj / l * if i == j { 1.0 } else { -1.0 };
            m[a][b] += inertia * l / 6.0 * if i == j { 2.0 } else { 1.0 };
        }
    }
    (k, m)
}

/// CPU seconds of this process so far, where the system tells; memory at its peak, MiB.
fn usage() -> (f64, f64) {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks: f64 = after.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find(|l| l.starts_with("VmHWM")).and_then(|l| l.split_whitespace().nth(1));
    (ticks / 100.0, peak.and_then(|p| p.parse::<f64>().ok()).unwrap_or(0.0) / 1024.0)
}

fn dump(folder: &str, name: &str, a: &SparseSym) -> std::io::Result<()> {
    let file = |part: &str| std::fs::File::create(format!("{folder}/{name}_{part}")).map(std::io::BufWriter::new);
    let (mut rows, mut columns, mut values) = (file("rows.i64")?, file("columns.i64")?, file("values.f64")?);
    for (i, j, value) in a.entries() {
        rows.write_all(&(i as i64).to_le_bytes())?;
        columns.write_all(&(j as i64).to_le_bytes())?;
        values.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut plain = arguments.iter().filter(|a| !a.starts_with("--"));
    let side: usize = plain.next().map_or(Ok(58), |a| a.parse())?;
    let folder = plain.next();
    let n = 3 * side * side;
    // 1 m by 1.3 m, and one half stiffer: no double modes.
    let (dx, dy) = (1.0 / (side - 1) as f64, 1.3 / (side - 1) as f64);
    let at = |i: usize, j: usize| i * side + j;
    let (mut k, mut m) = (Vec::new(), Vec::new());
    for i in 0..side {
        for j in 0..side {
            let stiffness = if 2 * i < side { 1.0 } else { 1.5 };
            let along_x = (i + 1 < side).then(|| (at(i + 1, j), beam(true, dx, stiffness)));
            let along_y = (j + 1 < side).then(|| (at(i, j + 1), beam(false, dy, stiffness)));
            for (other, (ke, me)) in along_x.into_iter().chain(along_y) {
                let dof = |a: usize| if a < 3 { 3 * at(i, j) + a } else { 3 * other + a - 3 };
                for a in 0..6 {
                    for b in 0..=a {
                        for (list, e) in [(&mut k, &ke), (&mut m, &me)] {
                            if e[a][b] != 0.0 {
                                list.push((dof(a), dof(b), e[a][b]));
                            }
                        }
                    }
                }
            }
        }
    }
    let k = SparseSym::from_triplets(n, k.into_iter());
    let m = SparseSym::from_triplets(n, m.into_iter());
    // Heave, roll, pitch, made M-orthonormal.
    let motions = DMatrix::from_fn(n, 3, |row, motion| {
        let (node, dof) = (row / 3, row % 3);
        let (x, y) = ((node / side) as f64 * dx - 0.5, (node % side) as f64 * dy - 0.65);
        [[1.0, 0.0, 0.0], [y, 1.0, 0.0], [-x, 0.0, 1.0]][motion][dof]
    });
    let gram = motions.transpose() * m.mul(&motions);
    let eigen = SymmetricEigen::new(gram);
    let scaled = DMatrix::from_fn(3, 3, |i, j| eigen.eigenvectors[(i, j)] / eigen.eigenvalues[j].sqrt());
    let rigid = motions * scaled;
    if let Some(folder) = folder {
        dump(folder, "stiffness", &k)?;
        dump(folder, "mass", &m)?;
    }
    let begin = (usage().0, Instant::now());
    let plan = SparsePlan::new(&k, &m, &(0..n).map(|row| row / 3).collect::<Vec<_>>())?;
    let planned = usage().0;
    let options =
        SparseOptions { n_modes: 20, count: !arguments.iter().any(|a| a == "--no-count"), ..SparseOptions::default() };
    let modes = lowest_sparse_modes(&plan, &k, &m, &rigid, None, &options)?;
    let (cpu, peak) = usage();
    println!("dofs {n}, factor {:.1} million values", plan.factor_len() as f64 / 1e6);
    println!(
        "cpu {:.2} s ({:.2} s order and structure), wall {:.2} s, peak {peak:.0} MiB",
        cpu - begin.0,
        planned - begin.0,
        begin.1.elapsed().as_secs_f64()
    );
    println!(
        "shift {:.3e}, {} block solves, {} factorisations, residual {:.1e}, count {:?}",
        modes.shift, modes.block_solves, modes.factorisations, modes.residual, modes.count
    );
    println!("backward error {:.1e}", backward_error(&k, &m, &modes.values, &modes.vectors));
    let hz: Vec<String> =
        modes.values.iter().map(|v| format!("{:.9}", v.max(0.0).sqrt() / std::f64::consts::TAU)).collect();
    println!("Hz {}", hz.join(" "));
    if let Some(folder) = folder {
        let text: Vec<String> = modes.values.iter().map(|v| format!("{v:.17e}")).collect();
        std::fs::write(format!("{folder}/values.txt"), text.join("\n"))?;
        std::fs::write(format!("{folder}/shift.txt"), format!("{:.17e}", modes.shift))?;
        std::fs::write(format!("{folder}/cpu.txt"), format!("{:.3} {peak:.0}", cpu - begin.0))?;
    }
    Ok(())
}
