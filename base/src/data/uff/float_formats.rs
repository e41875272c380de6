//! Floating-point formats of binary datasets: IEEE 754, DEC VMS and IBM 370.
//!
//! ```text
//! DEC F, D   value = (-1)^s 0.1f₂ 2^(e-128)          e: 8 bits, f: 23 or 55 bits, in 16-bit words, high word first
//! IBM 370    value = (-1)^s 0.f₁₆ 16^(e-64)          e: 7 bits, f: 24 or 56 bits
//! ```
//!
//! DEC numbers stand in memory as 16-bit words, each with its bytes in the stated order; a zero exponent is zero, or
//! with a minus sign a reserved operand, which becomes NaN. A double has more fraction bits than IEEE 754 and is
//! rounded to nearest.
//!
//! Sources: DEC, VAX Architecture Reference Manual, 1987, section 2.2; IBM, System/370 Principles of Operation,
//! GA22-7000, 1974, section "Floating-point arithmetic".

use super::function::ByteOrder;

/// Representation of numbers in a binary dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FloatFormat {
    /// DEC VMS: F_floating single, D_floating double.
    DecVms,
    /// IEEE 754.
    Ieee,
    /// IBM 370 hexadecimal.
    Ibm370,
}

/// The bytes as an integer, most significant first, after undoing the order of storage.
fn bits(bytes: &[u8], order: ByteOrder, format: FloatFormat) -> u64 {
    let join = |acc: u64, b: u8| (acc << 8) | u64::from(b);
    match (format, order) {
        (FloatFormat::DecVms, ByteOrder::Little) => bytes.chunks(2).flat_map(|w| w.iter().rev().copied()).fold(0, join),
        (_, ByteOrder::Big) => bytes.iter().copied().fold(0, join),
        (_, ByteOrder::Little) => bytes.iter().rev().copied().fold(0, join),
    }
}

/// A number of four bytes.
pub(super) fn read_single(bytes: &[u8], order: ByteOrder, format: FloatFormat) -> f64 {
    let b = bits(bytes, order, format);
    match format {
        FloatFormat::Ieee => f64::from(f32::from_bits(b as u32)),
        FloatFormat::DecVms => dec(b << 32),
        FloatFormat::Ibm370 => ibm(b << 32),
    }
}

/// A number of eight bytes.
pub(super) fn read_double(bytes: &[u8], order: ByteOrder, format: FloatFormat) -> f64 {
    let b = bits(bytes, order, format);
    match format {
        FloatFormat::Ieee => f64::from_bits(b),
        FloatFormat::DecVms => dec(b),
        FloatFormat::Ibm370 => ibm(b),
    }
}

fn dec(b: u64) -> f64 {
    let sign = if b >> 63 == 1 { -1.0 } else { 1.0 };
    let exponent = (b >> 55 & 0xff) as i32;
    if exponent == 0 {
        return if sign < 0.0 { f64::NAN } else { 0.0 };
    }
    // Hidden bit, then 55 fraction bits: an integer of 56 bits, rounded to nearest by the conversion.
    let fraction = (1_u64 << 55 | b & ((1 << 55) - 1)) as f64;
    sign * fraction * 2.0_f64.powi(exponent - 128 - 56)
}

fn ibm(b: u64) -> f64 {
    let sign = if b >> 63 == 1 { -1.0 } else { 1.0 };
    let exponent = (b >> 56 & 0x7f) as i32;
    let fraction = (b & ((1 << 56) - 1)) as f64;
    sign * fraction * 16.0_f64.powi(exponent - 64 - 14)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dec_floats_by_the_reference_manual() {
        // VAX F_floating: 1.0 is 0x4080 in its first word, -10.5 is 0xC228; bytes of a word little end first.
        let f = |b: &[u8]| read_single(b, ByteOrder::Little, FloatFormat::DecVms);
        assert_eq!(f(&[0x80, 0x40, 0, 0]), 1.0);
        assert_eq!(f(&[0x28, 0xc2, 0, 0]), -10.5);
        assert_eq!(f(&[0, 0, 0, 0]), 0.0);
        assert!(f(&[0, 0x80, 0, 0]).is_nan());
        let big = read_single(&[0x40, 0x80, 0, 0], ByteOrder::Big, FloatFormat::DecVms);
        assert_eq!(big, 1.0);
        let d = read_double(&[0x80, 0x40, 0, 0, 0, 0, 1, 0], ByteOrder::Little, FloatFormat::DecVms);
        assert_eq!(d, 1.0); // 2^-55 above 1 is below half a unit of IEEE double
        let d = read_double(&[0x80, 0x40, 0, 0, 0, 0, 8, 0], ByteOrder::Little, FloatFormat::DecVms);
        assert_eq!(d, 1.0 + f64::EPSILON);
    }

    #[test]
    fn ibm_floats_by_the_principles_of_operation() {
        // The textbook example: -118.625 is 0xC276A000.
        let f = |b: &[u8]| read_single(b, ByteOrder::Big, FloatFormat::Ibm370);
        assert_eq!(f(&[0xc2, 0x76, 0xa0, 0]), -118.625);
        assert_eq!(f(&[0x41, 0x10, 0, 0]), 1.0);
        assert_eq!(read_single(&[0, 0, 0x10, 0x41], ByteOrder::Little, FloatFormat::Ibm370), 1.0);
        let d = read_double(&[0x41, 0x10, 0, 0, 0, 0, 0, 1], ByteOrder::Big, FloatFormat::Ibm370);
        assert_eq!(d, 1.0 + 2.0_f64.powi(-52));
    }
}
