//! Reads PCD, the point clouds of PCL: ASCII, binary and compressed. Skips fields other than x, y
//! and z. Like PCL, it does not apply the viewpoint.

use super::lzf;
use crate::error::{Error, Result, quoted};
use crate::math::Vec3;
use crate::robot::{LoadLimit, LoadLimits};

/// Largest header line and largest point \[bytes\]; those in use have some hundred.
const MAX_LINE_BYTES: usize = 1 << 16;
const MAX_POINT_BYTES: usize = 1 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Data {
    Ascii,
    Binary,
    Compressed,
}

/// A field of every point.
struct Field {
    name: String,
    /// Bytes of each number.
    size: usize,
    /// `F` (float), `I` (signed) or `U` (unsigned), as in the header.
    kind: u8,
    /// Numbers of this field in each point.
    count: usize,
}

struct Header {
    fields: Vec<Field>,
    points: usize,
    data: Data,
}

/// Parses the points of a file \[m\].
pub(crate) fn points(file: &str, bytes: &[u8], limits: &LoadLimits) -> Result<Vec<Vec3>> {
    let (header, data) = header(file, bytes)?;
    limits.check(LoadLimit::Vertices, header.points, file, "header: POINTS")?;
    let axes = header.axes(file)?;
    if header.data == Data::Ascii {
        return ascii(file, &header, axes, data);
    }
    let point: usize = header.fields.iter().map(|field| field.size * field.count).sum();
    let too_many = || {
        let problem = format!("got {} points of {point} bytes, expected less than memory holds", header.points);
        Error::input(file, "header: POINTS", problem)
    };
    let needed = header.points.checked_mul(point).ok_or_else(too_many)?;
    let unpacked;
    let (data, rest) = if header.data == Data::Compressed {
        limits.check(LoadLimit::FileBytes, needed, file, "data")?;
        let (packed, rest) = packed(file, data, needed)?;
        unpacked = lzf::unpacked(packed, needed).map_err(|problem| Error::input(file, "data", problem))?;
        (&unpacked[..], rest)
    } else {
        data.split_at_checked(needed).ok_or_else(|| cut(file, data.len(), needed, header.points))?
    };
    if let Some(at) = rest.iter().position(|byte| *byte != 0 && !byte.is_ascii_whitespace()) {
        let problem = format!("got more than {} points (byte {at} after them), expected the end", header.points);
        return Err(Error::input(file, "data", problem));
    }
    let before = axes.map(|axis| header.fields[..axis].iter().map(|field| field.size * field.count).sum::<usize>());
    let mut points = Vec::with_capacity(header.points);
    for row in 0..header.points {
        points.push(Vec3::from([0, 1, 2].map(|axis| {
            let (field, before) = (&header.fields[axes[axis]], before[axis]);
            // Compressed files hold all numbers of a field one after another.
            let compressed = before * header.points + row * field.size;
            let at = if header.data == Data::Compressed { compressed } else { row * point + before };
            number(field.kind, &data[at..at + field.size])
        })));
    }
    Ok(points)
}

/// Decodes a number of a field, least significant byte first.
fn number(kind: u8, bytes: &[u8]) -> f64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let whole = u64::from_le_bytes(wide);
    let unused = 64 - 8 * bytes.len() as u32;
    match (kind, bytes.len()) {
        (b'F', 4) => f64::from(f32::from_bits(whole as u32)),
        (b'F', _) => f64::from_bits(whole),
        (b'I', _) => ((whole << unused) as i64 >> unused) as f64,
        _ => whole as f64,
    }
}

fn cut(file: &str, found: usize, needed: usize, points: usize) -> Error {
    let problem = format!("got {found} bytes, expected {needed} for the {points} points that its header announces");
    Error::input(file, "data", problem)
}

/// Returns the packed bytes of a compressed file, and the bytes after them.
fn packed<'a>(file: &str, data: &'a [u8], needed: usize) -> Result<(&'a [u8], &'a [u8])> {
    let fault = |problem: String| Error::input(file, "data", problem);
    let size = |at: usize| data.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let (Some(short), Some(long)) = (size(0), size(4)) else {
        return Err(fault(format!("got {} bytes, expected two sizes, then compressed points", data.len())));
    };
    if long != needed {
        return Err(fault(format!("got {long} bytes when decompressed, expected {needed} as the header has it")));
    }
    let rest = &data[8..];
    rest.split_at_checked(short).ok_or_else(|| fault(format!("got {} bytes, expected {short}", rest.len())))
}

fn ascii(file: &str, header: &Header, axes: [usize; 3], data: &[u8]) -> Result<Vec<Vec3>> {
    let text = String::from_utf8_lossy(data);
    let first = |axis: usize| header.fields[..axis].iter().map(|field| field.count).sum::<usize>();
    let columns = first(header.fields.len());
    let at = axes.map(first);
    let mut points: Vec<Vec3> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let fault = |problem: String| Error::input(file, format!("point {}", points.len() + 1), problem);
        if points.len() == header.points {
            return Err(fault(format!("got one more, expected {} as the header has it", header.points)));
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.len() != columns {
            return Err(fault(format!("got {} numbers, expected {columns} as the header has it", words.len())));
        }
        let mut point = [0.0; 3];
        for (x, column) in point.iter_mut().zip(at) {
            let wrong = || fault(format!("got `{}`, expected a number", quoted(words[column])));
            *x = words[column].parse().map_err(|_| wrong())?;
        }
        points.push(Vec3::from(point));
    }
    if points.len() < header.points {
        let problem = format!("got {} points, expected {} as the header has it", points.len(), header.points);
        return Err(Error::input(file, "data", problem));
    }
    Ok(points)
}

impl Header {
    /// Returns the indices of the fields x, y and z.
    fn axes(&self, file: &str) -> Result<[usize; 3]> {
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
            let field = self.fields.iter().position(|field| field.name == name && field.count == 1);
            let missing = || format!("got no `{name}` of one number, expected the fields x, y and z");
            *axis = field.ok_or_else(|| Error::input(file, "header: FIELDS", missing()))?;
        }
        Ok(axes)
    }
}

/// Parses the header, and returns the bytes after it.
fn header<'a>(file: &str, bytes: &'a [u8]) -> Result<(Header, &'a [u8])> {
    let mut rest = bytes;
    let mut lines: Vec<(String, Vec<String>)> = Vec::new();
    loop {
        let end = rest.iter().take(MAX_LINE_BYTES).position(|&byte| byte == b'\n');
        let Some(end) = end else {
            let problem = "got no line DATA, expected the header of a PCD, which ends with `DATA ascii`, `DATA binary` or \
                           `DATA binary_compressed`";
            return Err(Error::input(file, "header", problem));
        };
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = &rest[end + 1..];
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace().map(str::to_owned);
        let Some(key) = words.next() else { continue };
        if lines.iter().any(|(other, _)| *other == key) {
            return Err(Error::input(file, "header", format!("got a second line {}, expected one", quoted(&key))));
        }
        const KEYS: [&str; 11] =
            ["VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"];
        if !KEYS.contains(&key.as_str()) {
            let problem = format!("got `{}`, expected one of {}", quoted(&key), KEYS.join(", "));
            return Err(Error::input(file, "header", problem));
        }
        let is_last = key == "DATA";
        lines.push((key, words.collect()));
        if is_last {
            return Ok((resolved(file, &lines)?, rest));
        }
    }
}

fn resolved(file: &str, lines: &[(String, Vec<String>)]) -> Result<Header> {
    let line = |key: &str| lines.iter().find(|(name, _)| name == key).map(|(_, words)| &words[..]);
    let fault = |key: &str, problem: String| Error::input(file, format!("header: {key}"), problem);
    let listed = |key: &str| line(key).map_or_else(String::new, |words| quoted(&words.join(" ")).to_string());
    let names = line("FIELDS").or(line("COLUMNS")).unwrap_or_default();
    let mut fields = Vec::with_capacity(names.len());
    let each = |key: &str| match line(key) {
        Some(words) if words.len() == names.len() => Ok(Some(words)),
        None if key == "COUNT" => Ok(None),
        _ => Err(fault(key, format!("got `{}`, expected one for each of {} fields", listed(key), names.len()))),
    };
    let (sizes, kinds, counts) = (each("SIZE")?, each("TYPE")?, each("COUNT")?);
    let mut point = 0;
    for (k, name) in names.iter().enumerate() {
        let word = |words: Option<&[String]>| words.map_or("1".to_owned(), |words| words[k].clone());
        let (size, kind, count) = (word(sizes).parse(), word(kinds), word(counts).parse::<usize>());
        let (size, kind) = match (size, kind.as_bytes()) {
            (Ok(size @ (1 | 2 | 4 | 8)), [kind @ (b'I' | b'U')]) => (size, *kind),
            (Ok(size @ (4 | 8)), [b'F']) => (size, b'F'),
            _ => {
                let problem = format!(
                    "got `{}` and `{}`, expected I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8",
                    listed("TYPE"),
                    listed("SIZE")
                );
                return Err(fault("TYPE and SIZE", problem));
            }
        };
        let count = count.ok().filter(|count| (1..=MAX_POINT_BYTES / size).contains(count));
        let count =
            count.ok_or_else(|| fault("COUNT", format!("got `{}`, expected small numbers from 1", listed("COUNT"))))?;
        point += size * count;
        if point > MAX_POINT_BYTES {
            return Err(fault(
                "COUNT",
                format!("got points of more than {MAX_POINT_BYTES} bytes, expected smaller ones"),
            ));
        }
        fields.push(Field { name: name.clone(), size, kind, count });
    }
    let whole = |key: &str| match line(key) {
        None => Ok(None),
        Some([word]) if word.parse::<u32>().is_ok() => Ok(word.parse::<usize>().ok()),
        Some(_) => Err(fault(key, format!("got `{}`, expected a whole number below 2^32", listed(key)))),
    };
    let (width, height, stated) = (whole("WIDTH")?, whole("HEIGHT")?, whole("POINTS")?);
    let product = width.map(|width| width.saturating_mul(height.unwrap_or(1)));
    let points = match (product, stated) {
        (Some(product), Some(stated)) if product != stated => {
            return Err(fault("POINTS", format!("got {stated}, expected WIDTH times HEIGHT: {product}")));
        }
        (product, stated) => stated.or(product).ok_or_else(|| fault("POINTS", "got none, expected how many".into()))?,
    };
    let data = match line("DATA") {
        Some([word]) if word == "ascii" => Data::Ascii,
        Some([word]) if word == "binary" => Data::Binary,
        Some([word]) if word == "binary_compressed" => Data::Compressed,
        _ => {
            return Err(fault(
                "DATA",
                format!("got `{}`, expected ascii, binary or binary_compressed", listed("DATA")),
            ));
        }
    };
    Ok(Header { fields, points, data })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f32; 3]; 4] = [[0., 0., 0.], [1., -0.5, 2.], [f32::NAN; 3], [1., 1., 1.]];

    fn head(count: usize, data: &str) -> String {
        format!(
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb x y z _\nSIZE 4 4 4 4 1\nTYPE U F F F U\n\
             COUNT 1 1 1 1 3\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {data}\n"
        )
    }

    fn ascii() -> Vec<u8> {
        let rows = POINTS.map(|[x, y, z]| format!("16711680 {x} {y} {z} 0 0 0\n"));
        (head(4, "ascii") + &rows.concat()).into_bytes()
    }

    fn binary() -> Vec<u8> {
        let mut bytes = head(4, "binary").into_bytes();
        for point in POINTS {
            bytes.extend(255u32.to_le_bytes());
            point.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([1, 2, 3]);
        }
        bytes
    }

    /// A compressed file: the numbers field by field, as literals and one repeat.
    fn compressed() -> Vec<u8> {
        let mut fields: Vec<u8> = Vec::new();
        for axis in 0..3 {
            POINTS.iter().for_each(|point| fields.extend(point[axis].to_le_bytes()));
        }
        fields.extend([9; 12]);
        // The colours are one zero, and fifteen repeats of it.
        let mut packed = vec![0, 0, 7 << 5, 6, 0];
        for run in fields.chunks(32) {
            packed.push(run.len() as u8 - 1);
            packed.extend(run);
        }
        let mut bytes = head(4, "binary_compressed").into_bytes();
        bytes.extend((packed.len() as u32).to_le_bytes());
        bytes.extend((16 + fields.len() as u32).to_le_bytes());
        bytes.extend(packed);
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Vec<Vec3>> {
        points("a.pcd", bytes, &LoadLimits::default())
    }

    fn is_cloud(found: &[Vec3]) -> bool {
        let same = |(found, point): (&Vec3, &[f32; 3])| {
            (0..3).all(|k| found[k] == f64::from(point[k]) || found[k].is_nan() && point[k].is_nan())
        };
        found.len() == POINTS.len() && found.iter().zip(&POINTS).all(same)
    }

    #[test]
    fn all_encodings_give_the_same_points() {
        for bytes in [ascii(), binary(), compressed(), [binary(), vec![0, b'\n']].concat()] {
            let found = read(&bytes).unwrap();
            assert!(is_cloud(&found), "{found:?}");
        }
        let windows = String::from_utf8(ascii()).unwrap().replace('\n', "\r\n");
        assert!(is_cloud(&read(windows.as_bytes()).unwrap()));
        let short = "FIELDS x y z\nSIZE 8 2 1\nTYPE F I U\nPOINTS 1\nDATA binary\n";
        let bytes = [short.as_bytes(), &2.5f64.to_le_bytes(), &(-7i16).to_le_bytes(), &[200]].concat();
        assert_eq!(read(&bytes).unwrap(), [Vec3::new(2.5, -7.0, 200.0)]);
        assert!(read(head(0, "ascii").as_bytes()).unwrap().is_empty());
    }

    #[test]
    fn every_truncation_is_an_error_and_no_change_panics() {
        for bytes in [ascii(), binary(), compressed()] {
            let whole = if bytes.ends_with(b"\n") { bytes.len() - 2 } else { bytes.len() };
            (0..whole).for_each(|length| assert!(read(&bytes[..length]).is_err(), "{length} of {}", bytes.len()));
            for at in 0..bytes.len() {
                for change in [1, 17, 128, 255] {
                    let mut spoiled = bytes.clone();
                    spoiled[at] = spoiled[at].wrapping_add(change);
                    let _ = read(&spoiled);
                }
            }
        }
    }

    #[test]
    fn faults_are_named() {
        let message = |from: &str, to: &str| {
            let text = String::from_utf8(ascii()).unwrap().replace(from, to);
            read(text.as_bytes()).unwrap_err().to_string()
        };
        assert!(message("FIELDS rgb x", "FIELDS rgb u").contains("a.pcd: header: FIELDS: got no `x` of one number"));
        assert!(message("SIZE 4", "SIZE 3").contains("header: TYPE and SIZE: got `U F F F U` and `3 4 4 4 1`"));
        assert!(
            message("TYPE U F", "TYPE U").contains("header: TYPE: got `U F F U`, expected one for each of 5 fields")
        );
        assert!(message("WIDTH 4", "WIDTH 5").contains("header: POINTS: got 4, expected WIDTH times HEIGHT: 5"));
        assert!(message("POINTS 4", "POINTS -4").contains("header: POINTS: got `-4`, expected a whole number"));
        assert!(message("1 1 1 1 3", "1 1 1 1 3000000").contains("header: COUNT: got `1 1 1 1 3000000`"));
        assert!(message("DATA ascii", "DATA text").contains("header: DATA: got `text`, expected ascii, binary"));
        assert!(message("VERSION", "VERZION").contains("header: got `VERZION`, expected one of VERSION, FIELDS"));
        assert!(message("-0.5", "half").contains("a.pcd: point 2: got `half`, expected a number"));
        assert!(message("1 1 1 0 0 0\n", "").contains("point 4: got 1 numbers, expected 7"));
        let more = [ascii(), b"1 1 1 1 1 1 1\n".to_vec()].concat();
        assert!(read(&more).unwrap_err().to_string().contains("point 5: got one more, expected 4"));
        let huge = head(4_000_000_000, "binary");
        assert!(read(huge.as_bytes()).unwrap_err().to_string().contains("header: POINTS: got 4000000000 corners"));
        let many = head(10_000_000, "binary");
        let message = read(many.as_bytes()).unwrap_err().to_string();
        assert!(message.contains("got 0 bytes, expected 190000000 for the 10000000 points"), "{message}");
        let far = [binary(), vec![7]].concat();
        assert!(read(&far).unwrap_err().to_string().contains("got more than 4 points"));
    }

    /// The axes come after as many fields as the header holds. Minutes would pass if every point
    /// added up the sizes of these fields.
    #[test]
    fn many_fields_cost_nothing_a_point() {
        let fields = 20_000;
        let line = |word: &str, axis: &str| format!("{}{axis}", word.repeat(fields));
        let head = |count: &str| {
            format!(
                "FIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\nPOINTS 500\nDATA binary\n",
                line("_ ", "x y z"),
                line("1 ", "4 4 4"),
                line("U ", "F F F"),
                line(count, "1 1 1")
            )
        };
        let empty = read(head("0 ").as_bytes()).unwrap_err().to_string();
        assert!(empty.contains("a.pcd: header: COUNT: got `0 0") && empty.contains("numbers from 1"), "{empty}");
        let mut bytes = head("1 ").into_bytes();
        let point = [vec![7; fields], [1f32, 2., 3.].map(f32::to_le_bytes).concat()].concat();
        (0..500).for_each(|_| bytes.extend(&point));
        let found = read(&bytes).unwrap();
        assert!(found.len() == 500 && found.iter().all(|p| *p == Vec3::new(1., 2., 3.)));
    }

    #[test]
    fn points_beyond_memory_are_refused() {
        let limits = LoadLimits::default().with(LoadLimit::Vertices, usize::MAX).with(LoadLimit::FileBytes, usize::MAX);
        let text = format!(
            "FIELDS x y z _\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1000000\nWIDTH {0}\nHEIGHT {0}\nDATA binary\n",
            u32::MAX
        );
        let message = points("a.pcd", text.as_bytes(), &limits).unwrap_err().to_string();
        assert!(message.contains("header: POINTS: got 18446744065119617025 points of 1000012 bytes"), "{message}");
    }
}
