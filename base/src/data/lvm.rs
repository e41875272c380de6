//! LabVIEW measurement files (`.lvm`): text with headers and columns.
//!
//! Read: version 2 with one segment; separator tab or comma, decimal point or comma; one column of x for each channel
//! (`X_Columns Multi`), one for all (`One`) or none (`No`). The header's `X_Dimension` is kept as text and not believed:
//! writers leave `Time` there for spectra, so that the caller must say what x is.
//!
//! Source: National Instruments, Specification for the LabVIEW Measurement File (.lvm), 2018.

/// A channel.
#[derive(Debug, Clone, PartialEq)]
pub struct LvmChannel {
    /// Title of its column.
    pub name: String,
    /// Label of its unit, such as `g`.
    pub y_unit: String,
    /// What x is, by the header; see the module for why not to believe it.
    pub x_dimension: String,
    /// First x and distance of x, by the header.
    pub x_start_step: Option<(f64, f64)>,
    /// x of each sample; computed from start and step where the file has no such column.
    pub x: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
}

/// Why an `.lvm` file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LvmError {
    /// Not the format.
    #[error("this is not a LabVIEW measurement file: the first line is not `LabVIEW Measurement`")]
    NotLvm,
    /// No end of a header.
    #[error("the file ends before `***End_of_Header***` of the segment")]
    NoHeaderEnd,
    /// A cell that is not a number.
    #[error("line {line}, column {column}: `{text}` is not a number")]
    Cell {
        /// Line of the file.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What stands there.
        text: String,
    },
    /// Neither x nor its start and step.
    #[error("channel {channel} has neither a column of x nor `X0` and `Delta_X`")]
    NoX {
        /// Channel, from 1.
        channel: usize,
    },
}

const HEADER_END: &str = "***End_of_Header***";

/// Reads the first segment of a file.
pub fn read(bytes: &[u8]) -> Result<Vec<LvmChannel>, LvmError> {
    let text: String = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    };
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    if !lines.next().is_some_and(|(_, l)| l.starts_with("LabVIEW Measurement")) {
        return Err(LvmError::NotLvm);
    }
    let mut separator = '\t';
    let mut has_decimal_comma = false;
    let mut x_columns = "One".to_owned();
    let mut segment: Vec<Vec<&str>> = Vec::new();
    let mut headers_ended = 0;
    for (_, line) in lines.by_ref() {
        if line.starts_with(HEADER_END) {
            headers_ended += 1;
            if headers_ended == 2 {
                break;
            }
            continue;
        }
        let value = line.split(['\t', ',']).nth(1).unwrap_or("").trim();
        match line.split(['\t', ',']).next().unwrap_or("").trim() {
            "Separator" if value.eq_ignore_ascii_case("comma") => separator = ',',
            "Decimal_Separator" => has_decimal_comma = line.trim_end().ends_with(',') && separator == '\t',
            "X_Columns" => value.clone_into(&mut x_columns),
            _ => {}
        }
        if headers_ended == 1 {
            segment.push(line.split(separator).map(str::trim).collect());
        }
    }
    if headers_ended < 2 {
        return Err(LvmError::NoHeaderEnd);
    }
    let Some((_, titles)) = lines.next() else { return Ok(Vec::new()) };
    let mut titles: Vec<&str> = titles.split(separator).map(str::trim).collect();
    if titles.last().is_some_and(|t| t.eq_ignore_ascii_case("comment")) {
        titles.pop();
    }
    let mode = match x_columns.as_str() {
        "Multi" => XColumns::Multi,
        "No" => XColumns::No,
        _ => XColumns::One,
    };
    // The columns of x and y of each channel.
    let columns: Vec<(Option<usize>, usize)> = match mode {
        XColumns::Multi => (0..titles.len() / 2).map(|i| (Some(2 * i), 2 * i + 1)).collect(),
        XColumns::One => (1..titles.len()).map(|i| (Some(0), i)).collect(),
        // LabVIEW keeps an empty column of x.
        XColumns::No => (1..titles.len()).map(|i| (None, i)).collect(),
    };
    let number = |text: &str| {
        if has_decimal_comma { text.replace(',', ".").parse::<f64>().ok() } else { text.parse().ok() }
    };
    let header = |key: &str, channel: usize| {
        segment.iter().find(|row| row[0] == key).and_then(|row| row.get(channel + 1).or(row.get(1))).copied()
    };
    let mut channels: Vec<LvmChannel> = columns
        .iter()
        .enumerate()
        .map(|(i, (_, y))| LvmChannel {
            name: titles[*y].to_owned(),
            y_unit: header("Y_Unit_Label", i).unwrap_or("").to_owned(),
            x_dimension: header("X_Dimension", i).unwrap_or("").to_owned(),
            x_start_step: header("X0", i).and_then(number).zip(header("Delta_X", i).and_then(number)),
            x: Vec::new(),
            y: Vec::new(),
        })
        .collect();
    for (line, text) in lines {
        if text.trim().is_empty() {
            continue;
        }
        let cells: Vec<&str> = text.split(separator).map(str::trim).collect();
        let cell = |column: usize| -> Result<Option<f64>, LvmError> {
            match cells.get(column).copied().unwrap_or("") {
                // Channels may have different lengths.
                "" => Ok(None),
                text => match number(text) {
                    Some(value) => Ok(Some(value)),
                    None => Err(LvmError::Cell { line, column: column + 1, text: text.chars().take(40).collect() }),
                },
            }
        };
        for (channel, (x, y)) in channels.iter_mut().zip(&columns) {
            let Some(value) = cell(*y)? else { continue };
            if let Some(x) = x
                && let Some(x) = cell(*x)?
            {
                channel.x.push(x);
            }
            channel.y.push(value);
        }
    }
    for (i, channel) in channels.iter_mut().enumerate() {
        if channel.x.len() != channel.y.len() {
            let (start, step) = channel.x_start_step.ok_or(LvmError::NoX { channel: i + 1 })?;
            channel.x = (0..channel.y.len()).map(|k| start + k as f64 * step).collect();
        }
    }
    Ok(channels)
}

#[derive(Clone, Copy)]
enum XColumns {
    No,
    One,
    Multi,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cantilever_spectrum_has_its_peaks() {
        // Averaged FFT of an impulse test of a steel cantilever, dB(g) (PujaChowdhury/Dataset-4, CC BY-SA 4.0).
        let Some(folder) = crate::data::shared_data("cantilever_chowdhury") else { return };
        let channels = read(&std::fs::read(folder.join("FFT_data.lvm")).unwrap()).unwrap();
        let c = &channels[0];
        assert_eq!((channels.len(), c.y.len(), c.y_unit.as_str()), (1, 150_000, "g"));
        assert_eq!((c.name.as_str(), c.x_dimension.as_str()), ("Acceleration (FFT - (RMS))", "Time"));
        assert_eq!((c.x[3], c.y[3], c.x_start_step), (0.256, -101.410594, Some((0.0, 0.085333))));
    }

    #[test]
    fn a_decimal_comma_and_a_shared_column_of_x_are_understood() {
        let text = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n***End_of_Header***\t\n\t\n\
                    Channels\t2\t\nY_Unit_Label\tg\tN\nX0\t0,0\t0,0\nDelta_X\t0,5\t0,5\n***End_of_Header***\t\t\n\
                    X_Value\ta\tb\tComment\n0,0\t1,5\t-2\n0,5\t2,5\n";
        let channels = read(text.as_bytes()).unwrap();
        assert_eq!((channels[0].y.clone(), channels[1].y.clone()), (vec![1.5, 2.5], vec![-2.0]));
        assert_eq!((channels[1].y_unit.as_str(), channels[0].x[1]), ("N", 0.5));
        assert_eq!(read(b"hello"), Err(LvmError::NotLvm));
        let bad = text.replace("2,5", "2;5");
        assert_eq!(read(bad.as_bytes()), Err(LvmError::Cell { line: 14, column: 2, text: "2;5".into() }));
    }

    #[test]
    fn mutated_files_do_no_harm() {
        let seed: Vec<u8> = b"LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\n***End_of_Header***\t\n\t\nChannels\t2\t\nX0\t0\t0\nDelta_X\t0.5\t0.5\n***End_of_Header***\t\t\nX\ta\tX\tb\tComment\n0.0\t1.5\t0\t-2\n0.5\t2.5\n".to_vec();
        crate::data::mutate::all(&[seed], 5_000, |bytes| read(bytes).is_ok());
    }
}
