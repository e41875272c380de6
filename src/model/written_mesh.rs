//! Meshes that tests write.

use std::fmt::Write;

/// A mesh of version 2.2: nodes, and groups of cells of one type by their nodes, from one.
pub(crate) struct Written {
    pub(crate) nodes: Vec<[f64; 3]>,
    pub(crate) groups: Vec<(&'static str, u8, Vec<Vec<usize>>)>,
}

impl Written {
    pub(crate) fn new() -> Self {
        Self { nodes: Vec::new(), groups: Vec::new() }
    }

    pub(crate) fn node(&mut self, at: [f64; 3]) -> usize {
        self.nodes.push(at);
        self.nodes.len()
    }

    /// A rectangle with nodes of its own, in cells of two directions.
    pub(crate) fn sheet(
        &mut self,
        name: &'static str,
        origin: [f64; 3],
        [a, b]: [[f64; 3]; 2],
        [nx, ny]: [usize; 2],
    ) -> &mut Self {
        let mut id = vec![vec![0; ny + 1]; nx + 1];
        for (i, column) in id.iter_mut().enumerate() {
            for (j, node) in column.iter_mut().enumerate() {
                let at = |k: usize| origin[k] + a[k] * i as f64 / nx as f64 + b[k] * j as f64 / ny as f64;
                *node = self.node([at(0), at(1), at(2)]);
            }
        }
        let cell = |i: usize, j: usize| vec![id[i][j], id[i + 1][j], id[i + 1][j + 1], id[i][j + 1]];
        let cells = (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))).map(|(i, j)| cell(i, j)).collect();
        self.groups.push((name, 3, cells));
        self
    }

    /// Nodes at one place become one.
    pub(crate) fn merged(&mut self) -> &mut Self {
        let key = |p: &[f64; 3]| p.map(|v| (v * 1e6).round() as i64);
        let first: Vec<usize> =
            self.nodes.iter().map(|p| self.nodes.iter().position(|q| key(p) == key(q)).unwrap() + 1).collect();
        self.groups.iter_mut().flat_map(|g| &mut g.2).flatten().for_each(|n| *n = first[*n - 1]);
        self
    }

    pub(crate) fn text(&self) -> String {
        let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", self.groups.len());
        for (k, (name, kind, _)) in self.groups.iter().enumerate() {
            writeln!(text, "{} {} \"{name}\"", if *kind < 4 { 2 } else { 3 }, k + 1).unwrap();
        }
        writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", self.nodes.len()).unwrap();
        for (i, [x, y, z]) in self.nodes.iter().enumerate() {
            writeln!(text, "{} {x} {y} {z}", i + 1).unwrap();
        }
        let total: usize = self.groups.iter().map(|g| g.2.len()).sum();
        writeln!(text, "$EndNodes\n$Elements\n{total}").unwrap();
        let mut id = 0;
        for (k, (_, kind, cells)) in self.groups.iter().enumerate() {
            for cell in cells {
                id += 1;
                let nodes: Vec<String> = cell.iter().map(ToString::to_string).collect();
                writeln!(text, "{id} {kind} 2 {} 1 {}", k + 1, nodes.join(" ")).unwrap();
            }
        }
        text + "$EndElements\n"
    }
}
