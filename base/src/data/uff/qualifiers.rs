//! Dataset 1858: qualifiers of functions, such as their window.

use super::cursor::{Cursor, Fault};
use super::sink::Sink;

/// Dataset 1858: what dataset 58 has no room for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Qualifiers {
    /// Record 1: number of the set, octave format, run of the measurement, three unused.
    pub set: [i64; 6],
    /// Record 2: weighting, window (1 Hanning narrow, 2 Hanning broad, 3 flat top, 4 exponential, 5 impact, 6 impact and exponential), scale
    /// of amplitudes, normalisation, qualifiers of the data types of four axes, sampling, three unused.
    pub form: [i64; 12],
    /// Record 3: values of the z axis as speed, time and order, number of samples, one unused.
    pub z: [f64; 5],
    /// Record 4: four values of the user, damping factor of the exponential window.
    pub user: [f64; 5],
    /// Record 5: unused by the standard; some programs write levels here.
    pub levels: [f64; 5],
    /// Record 6: directions of response and reference, as text.
    pub directions: String,
    /// Record 7: unused.
    pub remark: String,
}

impl Qualifiers {
    /// Damping factor of an exponential window, where the functions have one.
    ///
    /// ```text
    /// w(t) = exp(-factor · t),   factor in 1/s
    /// ```
    pub fn exponential_window(&self) -> Option<f64> {
        const EXPONENTIAL: [i64; 2] = [4, 6];
        let factor = self.user[4];
        (factor.is_finite() && factor > 0.0 && (self.form[1] == 0 || EXPONENTIAL.contains(&self.form[1])))
            .then_some(factor)
    }
}

pub(super) fn read_1858(cursor: &mut Cursor<'_, '_>) -> Result<Qualifiers, Fault> {
    let set = cursor.numbers(&[12; 6], "the number of the set (record 1)")?;
    let form = cursor.numbers(&[6; 12], "the window (record 2)")?;
    let mut reals = [[0.0; 5]; 3];
    for (own, what) in reals.iter_mut().zip(["the z axis (record 3)", "the damping factor (record 4)", "record 5"]) {
        let n = cursor.numbers(&[15; 5], what)?;
        *own = std::array::from_fn(|i| n.float(i));
    }
    let [z, user, levels] = reals;
    Ok(Qualifiers {
        set: std::array::from_fn(|i| set.int(i)),
        form: std::array::from_fn(|i| form.int(i)),
        z,
        user,
        levels,
        directions: cursor.text(),
        remark: cursor.text(),
    })
}

pub(super) fn write_1858(q: &Qualifiers, sink: &mut Sink) {
    sink.begin(1858);
    sink.ints(&q.set.map(|v| (v, 12)));
    sink.end_record();
    sink.ints(&q.form.map(|v| (v, 6)));
    sink.end_record();
    for record in [q.z, q.user, q.levels] {
        for value in record {
            sink.float(value, 15, 7);
        }
        sink.end_record();
    }
    sink.text(&q.directions);
    sink.text(&q.remark);
    sink.end();
}
