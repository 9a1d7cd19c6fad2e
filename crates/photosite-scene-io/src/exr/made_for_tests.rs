//! EXR files written byte by byte, after "OpenEXR File Layout".

/// Values of a channel.
#[derive(Clone)]
pub(crate) enum Samples {
    F32(Vec<f32>),
    F16(Vec<u16>),
    U32(Vec<u32>),
}

impl Samples {
    /// Number of the type in channel lists, and the bytes of each value.
    fn bytes(&self) -> (i32, Vec<Vec<u8>>) {
        match self {
            Self::U32(values) => (0, values.iter().map(|value| value.to_le_bytes().to_vec()).collect()),
            Self::F16(values) => (1, values.iter().map(|value| value.to_le_bytes().to_vec()).collect()),
            Self::F32(values) => (2, values.iter().map(|value| value.to_le_bytes().to_vec()).collect()),
        }
    }
}

/// A part of a file, in uncompressed lines.
#[derive(Clone)]
pub(crate) struct Part {
    /// Name, type and value of attributes that not every file has.
    pub(crate) attributes: Vec<(&'static str, &'static str, Vec<u8>)>,
    /// Channels, sorted by name.
    pub(crate) channels: Vec<(&'static str, Samples)>,
    /// First column, first row, last column and last row that are stored.
    pub(crate) data: [i32; 4],
    /// First column, first row, last column and last row of the image.
    pub(crate) display: [i32; 4],
    /// Whether lines follow from the bottom to the top.
    pub(crate) decreasing: bool,
    /// Sampling: pixels of the image for each sample.
    pub(crate) sampling: i32,
}

impl Part {
    /// A row of pixels with these values of 32-bit channels.
    pub(crate) fn row(channels: &[(&'static str, &[f32])]) -> Self {
        let last = channels.first().map_or(0, |(_, values)| values.len() as i32 - 1);
        let channels = channels.iter().map(|(name, values)| (*name, Samples::F32(values.to_vec()))).collect();
        let window = [0, 0, last, 0];
        Self { attributes: Vec::new(), channels, data: window, display: window, decreasing: false, sampling: 1 }
    }

    pub(crate) fn with(mut self, name: &'static str, kind: &'static str, value: Vec<u8>) -> Self {
        self.attributes.push((name, kind, value));
        self
    }

    fn header(&self, is_of_many: bool) -> Vec<u8> {
        let mut channels = Vec::new();
        for (name, samples) in &self.channels {
            channels.extend([name.as_bytes(), &[0], &samples.bytes().0.to_le_bytes(), &[0; 4]].concat());
            channels.extend([self.sampling.to_le_bytes(), self.sampling.to_le_bytes()].concat());
        }
        channels.push(0);
        let window = |window: [i32; 4]| window.map(i32::to_le_bytes).concat();
        let rows = self.data[3] - self.data[1] + 1;
        let mut all = vec![
            ("channels", "chlist", channels),
            ("compression", "compression", vec![0]),
            ("dataWindow", "box2i", window(self.data)),
            ("displayWindow", "box2i", window(self.display)),
            ("lineOrder", "lineOrder", vec![u8::from(self.decreasing)]),
            ("screenWindowCenter", "v2f", floats(&[0.0; 2])),
            ("screenWindowWidth", "float", floats(&[1.0])),
        ];
        if !self.attributes.iter().any(|(name, ..)| *name == "pixelAspectRatio") {
            all.push(("pixelAspectRatio", "float", floats(&[1.0])));
        }
        if is_of_many {
            all.push(("type", "string", b"scanlineimage".to_vec()));
            all.push(("chunkCount", "int", rows.to_le_bytes().to_vec()));
        }
        all.extend(self.attributes.clone());
        let mut header = Vec::new();
        for (name, kind, value) in all {
            header.extend([name.as_bytes(), &[0], kind.as_bytes(), &[0]].concat());
            header.extend((value.len() as u32).to_le_bytes());
            header.extend(value);
        }
        header.push(0);
        header
    }

    /// Bytes of each line behind the number of its row, from the top.
    fn lines(&self) -> Vec<Vec<u8>> {
        let width = (self.data[2] - self.data[0] + 1) as usize;
        let channels: Vec<_> = self.channels.iter().map(|(_, samples)| samples.bytes().1).collect();
        let line = |row: usize| {
            let values: Vec<u8> = channels.iter().flat_map(|all| all[row * width..][..width].concat()).collect();
            let at = (self.data[1] + row as i32).to_le_bytes();
            [&at[..], &(values.len() as u32).to_le_bytes(), &values].concat()
        };
        (0..(self.data[3] - self.data[1] + 1) as usize).map(line).collect()
    }
}

/// A file of these parts.
pub(crate) fn file(parts: &[Part]) -> Vec<u8> {
    let is_of_many = parts.len() > 1;
    let flags = 2 | if is_of_many { 0x1000u32 } else { 0 };
    let mut file = [&[0x76, 0x2f, 0x31, 0x01], &flags.to_le_bytes()[..]].concat();
    parts.iter().for_each(|part| file.extend(part.header(is_of_many)));
    if is_of_many {
        file.push(0);
    }
    let lines: Vec<Vec<Vec<u8>>> = parts.iter().map(Part::lines).collect();
    let mut at = (file.len() + 8 * lines.iter().map(Vec::len).sum::<usize>()) as u64;
    let (mut offsets, mut chunks) = (Vec::new(), Vec::new());
    for (number, (part, lines)) in parts.iter().zip(&lines).enumerate() {
        let mut of_part = vec![0u64; lines.len()];
        let order: Vec<usize> =
            if part.decreasing { (0..lines.len()).rev().collect() } else { (0..lines.len()).collect() };
        for row in order {
            let prefix = if is_of_many { (number as u32).to_le_bytes().to_vec() } else { Vec::new() };
            of_part[row] = at;
            at += (prefix.len() + lines[row].len()) as u64;
            chunks.extend([prefix, lines[row].clone()].concat());
        }
        offsets.extend(of_part.into_iter().flat_map(u64::to_le_bytes));
    }
    [file, offsets, chunks].concat()
}

/// 32-bit floats as files have them.
pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
