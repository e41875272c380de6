//! Numbers with their derivatives by three variables: shape functions are written once.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dual {
    pub(super) value: f64,
    pub(super) slope: [f64; 3],
}

impl Dual {
    /// The variable number `i` at `value`.
    pub(super) fn variable(value: f64, i: usize) -> Self {
        let mut slope = [0.0; 3];
        slope[i] = 1.0;
        Self { value, slope }
    }

    fn with(self, other: Self, value: f64, own: f64, others: f64) -> Self {
        Self { value, slope: std::array::from_fn(|i| own * self.slope[i] + others * other.slope[i]) }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, slope: [0.0; 3] }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        self.with(b, self.value + b.value, 1.0, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self.with(b, self.value - b.value, 1.0, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        self.with(b, self.value * b.value, b.value, self.value)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        self.with(b, value, 1.0 / b.value, -value / b.value)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self::from(0.0) - self
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(self, b: f64) -> Self {
        self + Self::from(b)
    }
}

impl Sub<f64> for Dual {
    type Output = Self;
    fn sub(self, b: f64) -> Self {
        self - Self::from(b)
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, b: f64) -> Self {
        self * Self::from(b)
    }
}

impl Sub<Dual> for f64 {
    type Output = Dual;
    fn sub(self, b: Dual) -> Dual {
        Dual::from(self) - b
    }
}

impl Add<Dual> for f64 {
    type Output = Dual;
    fn add(self, b: Dual) -> Dual {
        Dual::from(self) + b
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;
    fn mul(self, b: Dual) -> Dual {
        Dual::from(self) * b
    }
}
