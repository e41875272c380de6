//! Where the strain energy of modes sits, and which way their sections move.

use super::character::{ModeCharacter, symmetry_index};
use super::compile::Model;
use super::dependence::strain_parts;
use super::placed_element::PlacedElement;
use super::{ModelError, ParametricModel};
use crate::element::{Axes, Dof};
use crate::linalg::{DMatrix, SymMatrix};

/// How the sections at every node move, on the line of their mass: where that line lies beside the nodes, a twist moves the nodes
/// and not the sections.
struct Motions {
    /// Per node and mode: squares of displacements along global axes, summed over the elements that meet there.
    squares: Vec<[f64; 3]>,
    /// Per node: how many elements meet there.
    elements: Vec<usize>,
    n_modes: usize,
}

impl Motions {
    fn new(n_nodes: usize, n_modes: usize) -> Self {
        Self { squares: vec![[0.0; 3]; n_nodes * n_modes], elements: vec![0; n_nodes], n_modes }
    }

    /// * `u` - displacements of the nodes of an element, in its axes
    /// * `line` - (y, z) of the line of its mass
    fn add(&mut self, element: &PlacedElement, mode: usize, u: &[f64], [y, z]: [f64; 2]) {
        for (k, &node) in element.nodes.iter().enumerate() {
            let [ux, uy, uz, rx, ry, rz] = std::array::from_fn(|d| u[6 * k + d]);
            // u + θ × (0, y, z)
            let local = [ux + z * ry - y * rz, uy - z * rx, uz + y * rx];
            let sum = &mut self.squares[node * self.n_modes + mode];
            for (global, sum) in sum.iter_mut().enumerate() {
                *sum += (0..3).map(|i| element.axes[i][global] * local[i]).sum::<f64>().powi(2);
            }
            self.elements[node] += usize::from(mode == 0);
        }
    }

    /// The mean over the elements that meet at a node; `None` where none does.
    fn squares(&self, node: usize, mode: usize) -> Option<[f64; 3]> {
        let n = self.elements[node];
        (n > 0).then(|| self.squares[node * self.n_modes + mode].map(|s| s / n as f64))
    }
}

impl Model {
    /// The characters of shapes of a model at θ, the first `n_rigid` of them rigid-body modes.
    pub(super) fn characters_at(
        &self,
        theta: &[f64],
        shapes: &DMatrix<f64>,
        n_rigid: usize,
    ) -> Result<Vec<ModeCharacter>, ModelError> {
        let mut energies = vec![[0.0; 5]; shapes.ncols()]; // axial, bending, torsion, springs, matrices
        // Of what is stretched: its energy times the square of its motion along itself over that of its motion.
        let mut along = vec![0.0; shapes.ncols()];
        let mut motions = Motions::new(self.dof_map().n_nodes(), shapes.ncols());
        for (i, e) in self.elements().iter().enumerate() {
            if let Some(matrices) = &e.matrices {
                let factor = e.stiffness_factor.as_ref().map_or(1.0, |f| f.at(theta));
                let Some(k) = &matrices.k else { continue };
                let follows = matrices.follows(self.dof_map());
                for (energy, q) in energies.iter_mut().zip(shapes.column_iter()) {
                    energy[4] += factor * follows.energy(k, q.as_slice());
                }
                continue;
            }
            let parts = strain_parts(e, theta)?;
            let k = if parts.is_none() { Some(self.element_matrices(i, theta)?.stiffness) } else { None };
            let is_line = e.kind.axes() == Axes::AlongNodes;
            let line = is_line.then(|| e.mass_axis(theta));
            for (mode, (energy, q)) in energies.iter_mut().zip(shapes.column_iter()).enumerate() {
                let u = self.element_displacements(i, q.as_slice());
                let force = |k: &SymMatrix| {
                    let mut out = vec![0.0; u.len()];
                    k.multiply(&u, &mut out);
                    out
                };
                let axial_before = energy[0];
                let of = |k: &SymMatrix| -> f64 { force(k).iter().zip(&u).map(|(f, u)| f * u).sum() };
                match (&parts, &k) {
                    (Some(p), _) => {
                        for (sum, part) in energy.iter_mut().zip([&p.axial, &p.bending, &p.torsion]) {
                            *sum += of(part);
                        }
                    }
                    // By the work of its end forces: exact in the sum, and of an element whose line is the line of its nodes.
                    (None, Some(k)) if is_line && !k.is_zero() => {
                        for (dof, (f, u)) in force(k).iter().zip(&u).enumerate() {
                            energy[[0, 1, 1, 2, 1, 1][dof % 6]] += f * u;
                        }
                    }
                    // Kinds of strain of a surface or a volume are not told apart, as those of matrices are not.
                    (None, Some(k)) if !k.is_zero() => energy[if e.nodes.len() > 2 { 4 } else { 3 }] += of(k),
                    _ => {}
                }
                if let Some(line) = line {
                    let square = |of: &dyn Fn(usize) -> bool| -> f64 {
                        u.iter().enumerate().filter(|(dof, _)| of(dof % 6)).map(|(_, u)| u * u).sum()
                    };
                    let (own, all) = (square(&|dof| dof == 0), square(&|dof| dof < 3));
                    if all > 0.0 {
                        along[mode] += (energy[0] - axial_before) * own / all;
                    }
                    motions.add(e, mode, &u, line);
                }
            }
        }
        let dofs = self.dof_map();
        let is_along = |r: &(usize, Dof), axis: usize| !r.1.is_rotation() && r.1.axis() == axis;
        let moves = |axis: usize| dofs.rows().iter().any(|r| is_along(r, axis) && !dofs.is_coordinate(r.0));
        let names_direction = (0..3).filter(|a| moves(*a)).count() > 1;
        let mut out = Vec::with_capacity(energies.len());
        for (mode, (energy, q)) in energies.iter().zip(shapes.column_iter()).enumerate() {
            let mut c = ModeCharacter { is_rigid: mode < n_rigid, names_direction, ..ModeCharacter::default() };
            c.symmetry = self.mirror().map(|m| symmetry_index(m, |i| q[i]));
            let total: f64 = energy.iter().sum();
            if total > 0.0 && !c.is_rigid {
                [c.axial, c.bending, c.torsion, c.springs, c.matrices] = energy.map(|e| e / total);
                c.along = if energy[0] > 0.0 { along[mode] / energy[0] } else { 0.0 };
            }
            let mut square = [0.0; 3];
            for node in (0..dofs.n_nodes()).filter(|&n| !dofs.is_coordinate(n)) {
                let own = |axis: usize| -> f64 {
                    dofs.express(node, Dof::ALL[axis]).iter().map(|&(row, f)| f * q[row]).sum::<f64>().powi(2)
                };
                let squares = motions.squares(node, mode).unwrap_or_else(|| std::array::from_fn(own));
                square.iter_mut().zip(squares).for_each(|(sum, s)| *sum += s);
            }
            let sum: f64 = square.iter().sum();
            if sum > 0.0 {
                c.direction = square.map(|s| s / sum);
            }
            out.push(c);
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    /// A cantilever whose line of nodes lies at the centre of its section, or beside it: energies and directions are those of the section.
    #[test]
    fn a_character_does_not_depend_on_where_the_nodes_lie() {
        let characters = |offsets: &str| {
            let text = format!(
                "retune: 1\nname: c\nsections:\n  s: {{E: 70 GPa, nu: 0.3, density: 2700 kg/m3, shape: {{rectangle: {{width: 50 mm, height: 20 mm}}}}{offsets}}}\n\
                 nodes: {{a: [0, 0, 0], b: [1 m, 0, 0]}}\nbeams: {{ab: {{nodes: [a, b], section: s, subdivide: 20}}}}\nsupports: {{c: {{node: a}}}}\n"
            );
            let model = crate::model::load(&text, &crate::model::Registry::builtin()).unwrap().0;
            let options = crate::modal::SolveOptions { n_elastic: 10, shift: None };
            let modes = crate::model::solve_modes(&model, &[], options).unwrap();
            model.characters_at(&[], &modes.shapes, modes.n_rigid).unwrap()
        };
        let centre = characters("");
        assert!((centre[5].torsion - 1.0).abs() < 1e-6, "{:?}", centre[5]);
        for offsets in [
            ", mass_offset_z: 0.05 m, shear_centre_z: 0.05 m",
            ", mass_offset_y: -0.2 m, shear_centre_y: -0.2 m, mass_offset_z: 0.01 m, shear_centre_z: 0.01 m",
        ] {
            for (mode, (a, b)) in centre.iter().zip(characters(offsets)).enumerate() {
                for (x, y) in [(a.torsion, b.torsion), (a.bending, b.bending), (a.axial, b.axial)] {
                    assert!((x - y).abs() < 1e-6, "mode {}: {a:?} {b:?}", mode + 1);
                }
                // In torsion the section turns in its place: its direction is rounding.
                for axis in (0..3).filter(|_| a.torsion < 0.5) {
                    assert!((a.direction[axis] - b.direction[axis]).abs() < 1e-6, "mode {}: {a:?} {b:?}", mode + 1);
                }
            }
        }
    }

    /// A frame that braces hold sways, a bar extends, and what nothing holds is a mechanism.
    #[test]
    fn what_is_stretched_extends_only_where_it_moves_along_itself() {
        let names = |text: &str| -> Vec<String> {
            let text =
                format!("retune: 1\nname: f\nsections: {{s: {{E: 200 GPa, density: 7850 kg/m3, A: 10 cm2}}}}\n{text}");
            let model =
                crate::model::load(&text, &crate::model::Registry::builtin()).unwrap_or_else(|p| panic!("{p:#?}")).0;
            let options = crate::modal::SolveOptions { n_elastic: 2, shift: None };
            let modes = crate::model::solve_modes(&model, &[], options).unwrap();
            crate::update::name_modes(&model, &[], &modes).unwrap().into_iter().map(|m| m.label).collect()
        };
        let frame = "active_dofs: [ux, uz]\nnodes: {a: [0, 0, 0], b: [3 m, 0, 0], c: [0, 0, 3 m], d: [3 m, 0, 3 m]}\n\
             elements:\n  ac: {type: bar, nodes: [a, c], section: s}\n  bd: {type: bar, nodes: [b, d], section: s}\n  cd: {type: bar, nodes: [c, d], section: s}\n";
        let ground = "supports: {ground: {nodes: [a, b]}}\n";
        assert_eq!(
            names(&format!("{frame}  ad: {{type: bar, nodes: [a, d], section: s}}\n{ground}"))[0],
            "1st Fore-aft Sway"
        );
        let chain = "active_dofs: [ux, uz]\nnodes: {a: [0, 0, 0], b: [1 m, 0, 0], c: [2 m, 0, 0], d: [3 m, 0, 0], e: [4 m, 0, 0]}\nelements:\n  bc: {type: bar, nodes: [b, c], section: s}\n\
             \x20 ab: {type: bar, nodes: [a, b], section: s}\n  cd: {type: bar, nodes: [c, d], section: s}\n  de: {type: bar, nodes: [d, e], section: s}\nsupports: {ground: {nodes: [a, e]}}\n";
        assert_eq!(names(chain)[1..4], ["2nd Rigid Body", "1st Mechanism", "1st Extension"]);
        let bar = "active_dofs: [ux, uz]\nnodes: {a: [0, 0, 0], b: [3 m, 0, 3 m]}\nelements:\n  ab: {type: bar, nodes: [a, b], section: s}\n\
             supports: {ground: {nodes: [a]}, guide: {nodes: [b], fixed: [ux]}}\n";
        assert_eq!(names(&bar.replace("[3 m, 0, 3 m]", "[0, 0, 3 m]"))[0], "1st Extension");
    }
}
