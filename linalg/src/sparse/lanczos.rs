//! Shift-invert block Lanczos with full reorthogonalisation and thick restart.
//!
//! The operator (K + aM)⁻¹ M is symmetric in the mass inner product; its largest θ = 1/(λ + a) belong to the lowest
//! modes. The mass inner product keeps its digits where that of K + aM would lose them: a fine mesh spreads λ over
//! more than ten decades.

use super::basis::{Block, Orthonormal, orthonormalise, scattered_block};
use super::factor::Factor;
use super::kernel::{Row, Small, WIDTH, grams, multiply, subtract};
use super::matrix::SparseSym;
use crate::decompositions::symmetric_pairs;
use crate::{DMatrix, LinalgError};

/// Approximate eigenpairs of the operator, θ descending.
#[derive(Debug)]
pub(super) struct Ritz {
    /// θ.
    pub(super) theta: Vec<f64>,
    /// |(K + aM)⁻¹ M x - θ x| in the mass norm: θ is wrong by no more.
    pub(super) residual: Vec<f64>,
    /// Coefficients of the vectors in the basis, as columns.
    coefficients: DMatrix<f64>,
}

/// The iteration in progress: OP Q = Q H + `next` R Eᵀ.
pub(super) struct Lanczos<'a, 'b> {
    mass: &'a SparseSym,
    factor: Factor<'a>,
    /// Vectors to stay away from, M-orthonormal: rigid-body modes.
    fixed: &'b [Block],
    blocks: Vec<Block>,
    /// H, with room for `most` blocks.
    h: DMatrix<f64>,
    /// The block to continue with, and M times it.
    next: Block,
    m_next: Block,
    /// How the last block leads to `next`.
    r: Small,
    /// Whether nothing is left to find.
    is_complete: bool,
    /// Whether `next` is coupled to every block: after a restart.
    is_coupled_to_all: bool,
    /// Most blocks at once.
    most: usize,
    steps: usize,
}

impl<'a, 'b> Lanczos<'a, 'b> {
    /// Begins with the block `start`, or with random vectors.
    pub(super) fn new(
        mass: &'a SparseSym,
        mut factor: Factor<'a>,
        fixed: &'b [Block],
        start: Option<Block>,
        most: usize,
        seed: u64,
    ) -> Self {
        let n = mass.n();
        let mut m_next = scattered_block(n, seed);
        // OP z rather than z: it has no part without mass.
        let z = start.unwrap_or_else(|| scattered_block(n, seed + 1));
        multiply(mass, &z, &mut m_next);
        let mut next = z;
        next.copy_from_slice(&m_next);
        factor.solve(&mut next);
        let fixed_rows: Vec<&[Row]> = fixed.iter().map(Vec::as_slice).collect();
        let all: Vec<usize> = (0..fixed.len()).collect();
        orthonormalise(mass, &mut next, &mut m_next, &fixed_rows, &all, seed + 2);
        let h = DMatrix::zeros(most * WIDTH, most * WIDTH);
        Self {
            mass,
            factor,
            fixed,
            blocks: Vec::new(),
            h,
            next,
            m_next,
            r: [[0.0; WIDTH]; WIDTH],
            is_complete: false,
            is_coupled_to_all: false,
            most,
            steps: 0,
        }
    }

    /// Number of vectors of the basis.
    pub(super) fn dimension(&self) -> usize {
        self.blocks.len() * WIDTH
    }

    /// Number of block solutions so far.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Whether the basis spans everything that has mass.
    pub(super) fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Adds a block to the basis, restarting when there is no room.
    pub(super) fn step(&mut self, keep: usize) -> Result<(), LinalgError> {
        if self.blocks.len() == self.most {
            self.restart(keep)?;
        }
        self.steps += 1;
        let mut w = self.m_next.clone();
        self.factor.solve(&mut w);
        self.blocks.push(std::mem::take(&mut self.next));
        let last = self.blocks.len() - 1;
        let n_fixed = self.fixed.len();
        let all: Vec<&[Row]> = self.fixed.iter().chain(&self.blocks).map(Vec::as_slice).collect();
        let first_near = if self.is_coupled_to_all { 0 } else { last.saturating_sub(1) };
        let near: Vec<usize> = (0..n_fixed).chain(n_fixed + first_near..all.len()).collect();
        let Orthonormal { r, coefficients, is_empty } =
            orthonormalise(self.mass, &mut w, &mut self.m_next, &all, &near, 1000 + self.steps as u64);
        for i in first_near..=last {
            let c = &coefficients[n_fixed + i];
            for a in 0..WIDTH {
                for b in 0..WIDTH {
                    let value = if i == last { 0.5 * (c[a][b] + c[b][a]) } else { c[a][b] };
                    self.h[(i * WIDTH + a, last * WIDTH + b)] = value;
                    self.h[(last * WIDTH + b, i * WIDTH + a)] = value;
                }
            }
        }
        self.is_coupled_to_all = false;
        self.next = w;
        self.r = r;
        self.is_complete = is_empty;
        Ok(())
    }

    /// The approximations that the basis holds.
    pub(super) fn ritz(&self) -> Result<Ritz, LinalgError> {
        let size = self.dimension();
        let (theta, coefficients) = symmetric_pairs(&self.h.view((0, 0), (size, size)).into_owned())?;
        let last = size - WIDTH;
        let residual = (0..size)
            .map(|j| {
                let sum = |k: usize| (0..WIDTH).map(|l| self.r[k][l] * coefficients[(last + l, j)]).sum::<f64>();
                (0..WIDTH).map(|k| sum(k).powi(2)).sum::<f64>().sqrt()
            })
            .collect();
        Ok(Ritz { theta, residual, coefficients })
    }

    /// One block of vectors from the basis: those of the indices `which`, the rest zero.
    fn combine(&self, coefficients: &DMatrix<f64>, which: std::ops::Range<usize>) -> Block {
        let mut out = vec![[0.0; WIDTH]; self.mass.n()];
        let rows: Vec<&[Row]> = self.blocks.iter().map(Vec::as_slice).collect();
        let small = |first: usize| -> Small {
            std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    let j = which.start + b;
                    if j < which.end { -coefficients[(first + a, j)] } else { 0.0 }
                })
            })
        };
        let parts: Vec<Small> = (0..rows.len()).map(|i| small(i * WIDTH)).collect();
        subtract(&mut out, &rows, &parts);
        out
    }

    /// Replaces the basis by its best `keep` vectors, rounded up to whole blocks.
    ///
    /// # Source
    /// K. Wu, H. Simon, Thick-restart Lanczos method for large symmetric eigenvalue problems, SIAM J. Matrix Anal. Appl.
    /// 22(2), 2000.
    fn restart(&mut self, keep: usize) -> Result<(), LinalgError> {
        let ritz = self.ritz()?;
        let n_blocks = keep.div_ceil(WIDTH).clamp(1, self.blocks.len() - 1);
        let blocks = (0..n_blocks).map(|b| self.combine(&ritz.coefficients, b * WIDTH..(b + 1) * WIDTH)).collect();
        self.blocks = blocks;
        self.h.fill(0.0);
        for j in 0..n_blocks * WIDTH {
            self.h[(j, j)] = ritz.theta[j];
        }
        self.is_coupled_to_all = true;
        Ok(())
    }

    /// The vectors of the first `count` approximations, M-normalised, improved by one application of the operator.
    ///
    /// ```text
    /// (K + aM)⁻¹ M x = θ x + q R s     q: the next block, s: the last coefficients of x
    /// ```
    ///
    /// It costs nothing, and takes off what rounding has left of directions without mass.
    ///
    /// # Source
    /// B. Nour-Omid, B. N. Parlett, T. Ericsson, P. S. Jensen, How to implement the spectral transformation, Math. Comp.
    /// 48(178), 1987.
    pub(super) fn vectors(&self, ritz: &Ritz, count: usize) -> Vec<Block> {
        let last = self.dimension() - WIDTH;
        let mut out = Vec::new();
        let mut mx = vec![[0.0; WIDTH]; self.mass.n()];
        for first in (0..count).step_by(WIDTH) {
            let which = first..(first + WIDTH).min(count);
            let mut block = self.combine(&ritz.coefficients, which.clone());
            let correction: Small = std::array::from_fn(|k| {
                std::array::from_fn(|b| {
                    let j = first + b;
                    if j >= which.end {
                        return 0.0;
                    }
                    let sum: f64 = (0..WIDTH).map(|l| self.r[k][l] * ritz.coefficients[(last + l, j)]).sum();
                    -sum / ritz.theta[j]
                })
            });
            subtract(&mut block, &[&self.next], &[correction]);
            multiply(self.mass, &block, &mut mx);
            let mut gram = [[[0.0; WIDTH]; WIDTH]];
            grams(&[&block], &mx, &mut gram);
            let norms: Row = std::array::from_fn(|l| gram[0][l][l].sqrt());
            for row in &mut block {
                for l in 0..which.len() {
                    row[l] /= norms[l];
                }
            }
            out.push(block);
        }
        out
    }

    /// The factor back, for another iteration or for its memory.
    pub(super) fn into_factor(self) -> Factor<'a> {
        self.factor
    }
}
