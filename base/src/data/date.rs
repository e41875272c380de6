//! The day of a test.

use super::uff::{Dataset, UniversalFile};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// A day of the Gregorian calendar; in files as ISO 8601 has it, `2014-05-22`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    year: u16,
    month: u8,
    day: u8,
}

const MONTHS: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
/// Two digits of a year from here on are of the last century (POSIX, `strptime`).
const OLD: u16 = 69;

impl Date {
    /// A day; none where the calendar has no such day.
    pub fn new(year: u16, month: u8, day: u8) -> Option<Self> {
        let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
        let days = match month {
            2 => 28 + u8::from(is_leap),
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return None,
        };
        (1..=days).contains(&day).then_some(Self { year, month, day })
    }

    /// The day that a record of a universal file begins with: `22-MAY-14`, `22-May-2014`, `2014-05-22`; a time may follow.
    ///
    /// Days and months as numbers alone, `05/06/14`, are read by no rule: programs write them in both orders.
    pub fn of_record(text: &str) -> Option<Self> {
        let word = text.split_whitespace().next()?;
        if let Ok(date) = word.parse() {
            return Some(date);
        }
        let mut parts = word.split(['-', '/', '.']);
        let (day, month, year) = (parts.next()?, parts.next()?.to_lowercase(), parts.next()?);
        let month = MONTHS.iter().position(|m| *m == month)? as u8 + 1;
        let number = |digits: &str| digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse::<u16>().ok())?;
        let year = match (year.len(), number(year)?) {
            (2, y) if y >= OLD => 1900 + y,
            (2, y) => 2000 + y,
            (4, y) => y,
            _ => return None,
        };
        (parts.next().is_none() && day.len() <= 2).then(|| Self::new(year, month, number(day)? as u8))?
    }
}

/// The first day on which functions of universal files were recorded (ID line 3 of dataset 58); without any, on which modes were stored (that of
/// datasets 55 and 2414), or on which the database was created (dataset 151).
pub(super) fn of_universal_files(files: &[UniversalFile]) -> Option<Date> {
    let all = || files.iter().flat_map(|f| &f.datasets);
    let functions = all().filter_map(|d| match d {
        Dataset::Function(f) => Date::of_record(&f.ids[2]),
        _ => None,
    });
    let headers = all().filter_map(|d| match d {
        Dataset::Header(h) => Date::of_record(&h.created.date),
        _ => None,
    });
    let modes = all().filter_map(|d| match d {
        Dataset::DataAtNodes(d) => Date::of_record(&d.ids[2]),
        Dataset::AnalysisData(d) => Date::of_record(&d.ids[2]),
        _ => None,
    });
    functions.min().or_else(|| modes.min()).or_else(|| headers.min())
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// Why a text is not a date.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a day: expected year, month and day such as `2014-05-22`")]
pub struct NoDate(String);

impl FromStr for Date {
    type Err = NoDate;

    fn from_str(text: &str) -> Result<Self, NoDate> {
        let of = || {
            let bytes = text.as_bytes();
            let is_iso = bytes.len() == 10
                && bytes
                    .iter()
                    .enumerate()
                    .all(|(i, b)| if i == 4 || i == 7 { *b == b'-' } else { b.is_ascii_digit() });
            is_iso.then(|| Self::new(text[..4].parse().ok()?, text[5..7].parse().ok()?, text[8..].parse().ok()?))?
        };
        of().ok_or_else(|| NoDate(text.to_string()))
    }
}

impl Serialize for Date {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Date {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Day;
        impl Visitor<'_> for Day {
            type Value = Date;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a day such as `2014-05-22`")
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Date, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Day)
    }
}

impl JsonSchema for Date {
    fn schema_name() -> Cow<'static, str> {
        "Date".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "format": "date"})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_read_as_files_write_them() {
        let day = Date::new(2014, 5, 22);
        assert_eq!("2014-05-22".parse().ok(), day);
        for text in ["22-MAY-14", "22-May-14 10:30:00", "22-May-2014", "22/may/2014", " 2014-05-22  10:30:00"] {
            assert_eq!(Date::of_record(text), day, "{text}");
        }
        assert_eq!(Date::of_record("9-Jan-87"), Date::new(1987, 1, 9));
        assert_eq!(Date::of_record("29-FEB-00"), Date::new(2000, 2, 29));
        assert_eq!(day.map(|d| d.to_string()).as_deref(), Some("2014-05-22"));
    }

    #[test]
    fn files_are_of_the_first_day_that_they_name() {
        let header = |date: &str| {
            let created = crate::data::uff::Stamp { date: date.into(), ..Default::default() };
            let header = crate::data::uff::Header { created, ..Default::default() };
            UniversalFile { datasets: vec![Dataset::Header(header)] }
        };
        let files = [header("23-MAY-14"), header("NONE"), header("22-MAY-14")];
        assert_eq!(of_universal_files(&files), Date::new(2014, 5, 22));
        assert_eq!(of_universal_files(&files[1..2]), None);
        // Modes alone, as an analyser exports them.
        let analysis = crate::data::uff::DataAtNodes {
            ids: ["rack", "NONE", "21-MAY-14 10:00:00", "NONE", "NONE"].map(str::to_owned),
            model_type: 1,
            analysis_type: 2,
            characteristic: 2,
            specific_type: 8,
            data_type: 2,
            values_per_node: 3,
            integers: vec![0, 1],
            reals: vec![3.0, 0.0, 0.0, 0.0],
            entries: Vec::new(),
        };
        let modes = UniversalFile { datasets: vec![Dataset::DataAtNodes(analysis)] };
        assert_eq!(of_universal_files(&[modes, header("23-MAY-14")]), Date::new(2014, 5, 21));
    }

    #[test]
    fn a_test_file_keeps_its_day_and_refuses_what_is_none() {
        let file = |date: &str| {
            format!(
                "retune_test: 1\nname: t\ndate: {date}\nsources: {{a: {{kind: measured, text: b}}}}\n\
                 modes: [{{frequency: 2 Hz, frequency_sd: 1 %, source: a}}]\n"
            )
        };
        let (test, _) = crate::data::read_test(&file("2014-05-22")).unwrap();
        assert_eq!(test.date, Date::new(2014, 5, 22));
        assert_eq!(crate::data::read_test(&crate::data::write_test(&test)).unwrap().0.date, test.date);
        for wrong in ["22.05.2014", "2014-02-30", "2014"] {
            let problems = crate::data::read_test(&file(wrong)).unwrap_err();
            assert!(problems[0].path == "date" && problems[0].location.is_some(), "{:?}", problems[0]);
        }
    }

    #[test]
    fn what_is_no_day_is_none() {
        for text in [
            "",
            "NONE",
            "05/06/14",
            "30-FEB-14",
            "22-MAI-14",
            "22-MAY",
            "22-MAY-014",
            "222-MAY-14",
            "22-MAY-14-1",
            "+1-MAY-14",
        ] {
            assert_eq!(Date::of_record(text), None, "{text}");
        }
        for text in ["2014-13-01", "2014-02-29", "2014-5-22", "20140522", "2014-05-2é", "2014-05-22T10"] {
            let e = text.parse::<Date>().unwrap_err().to_string();
            assert!(e.contains(text) && e.contains("2014-05-22"), "{e}");
        }
    }
}
