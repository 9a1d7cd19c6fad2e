//! Parquet files of Hugging Face `datasets`: a row a picture, with pictures as PNG. The file's key `huggingface` says
//! which columns are pictures; to `datasets` they are decoded ones.
//!
//! Raw images of one number a pixel, depth and numbers of instances are 16-bit grey PNG, which come back as they are.
//! Depth is along the axis, in steps of `depth_unit_m`, 0 where nothing is. Poses lead from the world to the camera, with
//! OpenCV's axes; matrices are row by row. `capture` is the text of `capture.json`.

use std::io;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use serde_json::{Value, json};

use super::container::Container;
use super::raw_png::{depth_png, numbers_png, raw_png};
use super::sample::Sample;
use crate::io::output::Sink;
use crate::{Error, Result};

/// A group of rows ends when it has so many bytes.
const ROW_GROUP_BYTES: u64 = 100 << 20;
/// What a row takes without its pictures and its report.
const ROW_BYTES: u64 = 512;

/// The columns, in the order in which they are written.
const SCHEMA: &str = "message schema {
    required binary camera (UTF8);
    required int32 frame;
    optional double time_s;
    required int64 stamp_ns;
    required int64 seed (INTEGER(64, false));
    optional group image { optional binary bytes; optional binary path (UTF8); }
    optional group raw { optional binary bytes; optional binary path (UTF8); }
    optional binary colour_filter_array (UTF8);
    optional group depth { optional binary bytes; optional binary path (UTF8); }
    optional double depth_unit_m;
    optional group instance { optional binary bytes; optional binary path (UTF8); }
    required binary projection (UTF8);
    optional group camera_matrix (LIST) { repeated group list { optional double element; } }
    optional group distortion (LIST) { repeated group list { optional double element; } }
    optional group rotation (LIST) { repeated group list { optional double element; } }
    optional group translation_m (LIST) { repeated group list { optional double element; } }
    required binary capture (UTF8);
}";

/// What `datasets` makes of them.
fn features() -> Value {
    let value = |kind: &str| json!({ "dtype": kind, "_type": "Value" });
    let list = || json!({ "feature": value("float64"), "_type": "Sequence" });
    let image = || json!({ "_type": "Image" });
    json!({
        "camera": value("string"),
        "frame": value("int32"),
        "time_s": value("float64"),
        "stamp_ns": value("int64"),
        "seed": value("uint64"),
        "image": image(),
        "raw": image(),
        "colour_filter_array": value("string"),
        "depth": image(),
        "depth_unit_m": value("float64"),
        "instance": image(),
        "projection": value("string"),
        "camera_matrix": list(),
        "distortion": list(),
        "rotation": list(),
        "translation_m": list(),
        "capture": value("string"),
    })
}

/// Parquet files.
pub(super) struct ParquetFile;

/// A row.
pub(super) struct Row {
    camera: String,
    frame: u32,
    time_s: Option<f64>,
    stamp_ns: u64,
    seed: u64,
    image: Option<Vec<u8>>,
    raw: Option<Vec<u8>>,
    colour_filter_array: Option<String>,
    depth: Option<Vec<u8>>,
    depth_unit_m: Option<f64>,
    instance: Option<Vec<u8>>,
    projection: &'static str,
    camera_matrix: [f64; 9],
    distortion: Vec<f64>,
    rotation: [f64; 9],
    translation_m: [f64; 3],
    capture: Vec<u8>,
}

impl Container for ParquetFile {
    type Item = Row;

    fn item(sample: Sample, warn: &dyn Fn(&str)) -> Result<Row> {
        let key = sample.key();
        let failed = |reason| Error::io(key.as_ref(), "write", reason);
        let raw = sample.raw.as_ref().map_or(Ok(None), raw_png).map_err(failed)?;
        if raw.is_none() && sample.raw.is_some() {
            warn(
                "Parquet files hold raw images of one number per pixel, and are without those of all channels at every pixel",
            );
        }
        let depth = sample.truth.get("depth").map(depth_png).transpose().map_err(failed)?;
        let instance = sample.truth.get("instance").map(|planes| numbers_png(planes, "instance")).transpose();
        let instance = instance.map_err(failed)?;
        if instance == Some(None) {
            warn(
                "Parquet files hold numbers of instances up to 65535, and are without those of pictures that have more",
            );
        }
        let others: Vec<&str> =
            sample.truth.keys().map(String::as_str).filter(|name| !["depth", "instance"].contains(name)).collect();
        if !others.is_empty() {
            let names = others.join(", ");
            warn(&format!("Parquet files hold depth and instance, and are without {names}, which webdataset holds"));
        }
        let (rotation, translation_m) = sample.pose();
        let camera = &sample.shot.calibrated;
        Ok(Row {
            camera: camera.name.clone(),
            frame: sample.shot.frame,
            time_s: sample.time_s,
            stamp_ns: sample.shot.stamp_ns,
            seed: sample.seed,
            colour_filter_array: sample.raw.as_ref().filter(|_| raw.is_some()).map(|raw| raw.cfa.to_string()),
            raw,
            depth_unit_m: depth.as_ref().map(|(_, unit)| *unit),
            depth: depth.map(|(png, _)| png),
            instance: instance.flatten(),
            projection: camera.projection.name(),
            camera_matrix: camera.matrix(),
            distortion: camera.projection.coefficients(),
            rotation,
            translation_m,
            image: sample.image,
            capture: sample.report,
        })
    }

    fn bytes(row: &Row) -> u64 {
        let pictures = [&row.image, &row.raw, &row.depth, &row.instance].into_iter().flatten();
        pictures.chain([&row.capture]).map(|bytes| bytes.len() as u64).sum::<u64>() + ROW_BYTES
    }

    fn write(items: &mut dyn Iterator<Item = io::Result<Row>>, to: &mut dyn Sink) -> io::Result<()> {
        let schema = Arc::new(parse_message_type(SCHEMA)?);
        let about = json!({ "info": { "features": features() } }).to_string();
        let properties = WriterProperties::builder()
            .set_created_by(format!("photosite {}", env!("CARGO_PKG_VERSION")))
            .set_compression(Compression::UNCOMPRESSED)
            .set_dictionary_enabled(false)
            .set_statistics_enabled(EnabledStatistics::None)
            // Pages are ended between batches alone, and pictures are large.
            .set_write_batch_size(16)
            .set_key_value_metadata(Some(vec![KeyValue::new("huggingface".to_owned(), about)]))
            .build();
        // The writer wants something that may go to another thread, and is emptied after each group.
        let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
        let (mut rows, mut bytes) = (Vec::new(), 0);
        for row in items {
            let row = row?;
            bytes += Self::bytes(&row);
            rows.push(row);
            if bytes >= ROW_GROUP_BYTES {
                write_rows(&mut writer, std::mem::take(&mut rows))?;
                writer.flush()?;
                to.write_all(&std::mem::take(writer.inner_mut()))?;
                bytes = 0;
            }
        }
        if !rows.is_empty() {
            write_rows(&mut writer, rows)?;
        }
        to.write_all(&writer.into_inner()?)
    }
}

fn write_rows(writer: &mut SerializedFileWriter<Vec<u8>>, rows: Vec<Row>) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    let text = |text: &str| ByteArray::from(text);
    let mut columns = Columns(&mut group);
    columns.required::<ByteArrayType>(rows.iter().map(|row| text(&row.camera)))?;
    columns.required::<Int32Type>(rows.iter().map(|row| row.frame as i32))?;
    columns.optional::<DoubleType>(rows.iter().map(|row| row.time_s))?;
    columns.required::<Int64Type>(rows.iter().map(|row| row.stamp_ns as i64))?;
    columns.required::<Int64Type>(rows.iter().map(|row| row.seed as i64))?;
    columns.picture(rows.iter().map(|row| &row.image))?;
    columns.picture(rows.iter().map(|row| &row.raw))?;
    columns.optional::<ByteArrayType>(rows.iter().map(|row| row.colour_filter_array.as_deref().map(text)))?;
    columns.picture(rows.iter().map(|row| &row.depth))?;
    columns.optional::<DoubleType>(rows.iter().map(|row| row.depth_unit_m))?;
    columns.picture(rows.iter().map(|row| &row.instance))?;
    columns.required::<ByteArrayType>(rows.iter().map(|row| text(row.projection)))?;
    columns.list(rows.iter().map(|row| row.camera_matrix.as_slice()))?;
    columns.list(rows.iter().map(|row| row.distortion.as_slice()))?;
    columns.list(rows.iter().map(|row| row.rotation.as_slice()))?;
    columns.list(rows.iter().map(|row| row.translation_m.as_slice()))?;
    columns.required::<ByteArrayType>(rows.iter().map(|row| ByteArray::from(row.capture.clone())))?;
    group.close().map(drop)
}

/// The columns of a group that are still to be written. Values stand with levels, as Dremel has them: how many of the
/// optional and repeated things around a value are there, and whether it goes on in a list.
struct Columns<'a, 'b>(&'a mut SerializedRowGroupWriter<'b, Vec<u8>>);

impl Columns<'_, '_> {
    fn next<T: DataType>(
        &mut self,
        values: &[T::T],
        there: Option<&[i16]>,
        goes_on: Option<&[i16]>,
    ) -> Result<(), ParquetError> {
        let end = || ParquetError::General("there are fewer columns than values".to_owned());
        let mut column = self.0.next_column()?.ok_or_else(end)?;
        column.typed::<T>().write_batch(values, there, goes_on)?;
        column.close()
    }

    fn required<T: DataType>(&mut self, values: impl Iterator<Item = T::T>) -> Result<(), ParquetError> {
        self.next::<T>(&values.collect::<Vec<_>>(), None, None)
    }

    fn optional<T: DataType>(&mut self, values: impl Iterator<Item = Option<T::T>>) -> Result<(), ParquetError> {
        let values: Vec<Option<T::T>> = values.collect();
        let there: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
        self.next::<T>(&values.into_iter().flatten().collect::<Vec<_>>(), Some(&there), None)
    }

    /// Its bytes, and a path that is null.
    fn picture<'c>(&mut self, pictures: impl Iterator<Item = &'c Option<Vec<u8>>>) -> Result<(), ParquetError> {
        let pictures: Vec<&Option<Vec<u8>>> = pictures.collect();
        let there = |level: i16| pictures.iter().map(|png| if png.is_some() { level } else { 0 }).collect::<Vec<_>>();
        let values: Vec<ByteArray> =
            pictures.iter().copied().flatten().map(|png| ByteArray::from(png.clone())).collect();
        self.next::<ByteArrayType>(&values, Some(&there(2)), None)?;
        self.next::<ByteArrayType>(&[], Some(&there(1)), None)
    }

    fn list<'c>(&mut self, lists: impl Iterator<Item = &'c [f64]>) -> Result<(), ParquetError> {
        let (mut values, mut there, mut goes_on) = (Vec::new(), Vec::new(), Vec::new());
        for list in lists {
            values.extend_from_slice(list);
            // An empty one is there, and nothing in it.
            there.extend(std::iter::repeat_n(if list.is_empty() { 1 } else { 3 }, list.len().max(1)));
            goes_on.extend((0..list.len().max(1)).map(|i| i16::from(i > 0)));
        }
        self.next::<DoubleType>(&values, Some(&there), Some(&goes_on))
    }
}
