//! A run as an MCAP file (`run --mcap`), for Foxglove and rerun: the bodies' poses as
//! `foxglove.FrameTransforms`, the signals of each component as one JSON message, and at the end the
//! findings as `foxglove.Log`. Poses are encoded here, because the crate `foxglove` takes twice as
//! long to compile as `mcap`, on which its own writer is built.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use anyhow::{Error, Result, bail, ensure};
use cosim::io::csv::{is_text, stride};
use cosim::run::observer::Observer;
use cosim::{Experiment, Master, Port, Signals, System, Verdict};
use hdrm::{BODIES, DOF, Tree};
use mcap::records::MessageHeader;
use mcap::write::{NoSeek, WriteOptions, Writer};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use output_file::OutputFile;
use serde_json::{Value, json};

use crate::setup::machine_choice::MachineFile;

const TRANSFORMS: &[u8] = include_bytes!("foxglove/FrameTransforms.bin");
const LOG: &[u8] = include_bytes!("foxglove/Log.bin");

/// A recording that gets its name when it is complete. If it is dropped before that, nothing is left.
pub struct Recorder {
    writer: Writer<NoSeek<OutputFile>>,
    /// Communication steps between rows.
    stride: u64,
    /// Joint angles, then position and orientation of the plant's tip.
    pose: Signals,
    tree: Tree,
    poses: u16,
    log: u16,
    topics: Vec<Topic>,
    rows: u32,
    last: Option<f64>,
}

/// The signals of a component.
struct Topic {
    channel: u16,
    message: Value,
    columns: Vec<Column>,
}

struct Column {
    port: Port,
    is_text: bool,
    /// Fields of the message down to the value, and its index in an array.
    path: Vec<String>,
    index: Option<usize>,
}

impl Recorder {
    /// Records the variables `ports` every `interval`, s, or at every communication point.
    pub fn create(
        path: &Path,
        system: &System,
        experiment: &Experiment,
        ports: &[Port],
        interval: Option<f64>,
    ) -> Result<Self> {
        let plant = system.port("tip.position[1]")?.component;
        let groups = [("zeta", DOF), ("tip.position", 3), ("tip.orientation", 4)];
        let groups = groups.map(|(name, count)| system.elements(plant, name, count));
        let pose: Vec<_> = groups.into_iter().collect::<Result<_>>()?;
        let file = system.port_of(plant, "machine_file")?;
        let file = MachineFile::from_parameter(system, &experiment.settings, file)?;
        let options = WriteOptions::new()
            .disable_seeking(true)
            .library("hdrm-fmu");
        let mut writer = options.create(NoSeek::new(OutputFile::create(path)?))?;
        let mut channel = |topic: &str, kind: [&str; 3], schema: &[u8]| {
            let id = writer.add_schema(kind[0], kind[1], schema)?;
            writer.add_channel(id, topic, kind[2], &BTreeMap::new())
        };
        let protobuf = |name| [name, "protobuf", "protobuf"];
        let poses = channel("/tf", protobuf("foxglove.FrameTransforms"), TRANSFORMS)?;
        let log = channel("/log", protobuf("foxglove.Log"), LOG)?;
        let mut topics = Vec::new();
        for (k, component) in system.structure.components.iter().enumerate() {
            let of_it = ports.iter().filter(|port| port.component == k);
            let columns: Vec<_> = of_it.map(|port| Column::new(system, *port)).collect();
            if columns.is_empty() {
                continue;
            }
            let (mut schema, mut message) = (json!({ "title": component.name }), Value::Null);
            for column in &columns {
                column.describe(system, &mut schema);
                *column.of(&mut message) = Value::Null;
            }
            let is_taken = |column: &&Column| !column.of(&mut message).is_null();
            if let Some(column) = columns.iter().find(is_taken) {
                let name = system.name(column.port);
                bail!(
                    "`{name}` and parts of it are no fields of one message: name others (--signals)"
                );
            }
            let (topic, kind) = (format!("/{}", component.name), &*component.name);
            let text = serde_json::to_vec(&schema)?;
            topics.push(Topic {
                channel: channel(&topic, [kind, "jsonschema", "json"], &text)?,
                message,
                columns,
            });
        }
        Ok(Self {
            writer,
            stride: stride(interval, experiment.stepping.step)?,
            pose: Signals::new(system, &pose.concat())?,
            tree: Tree::new(&file.machine)?,
            poses,
            log,
            topics,
            rows: 0,
            last: None,
        })
    }

    fn add_row(&mut self, master: &Master) -> Result<()> {
        let t = master.time();
        ensure!(
            t >= 0.0,
            "--mcap: no time may be before 0 s, the run starts at {t} s"
        );
        self.last = Some(t);
        let values = self.pose.read(master)?;
        let zeta = std::array::from_fn(|i| values[i]);
        let at = Vector3::from_column_slice(&values[DOF..DOF + 3]);
        let [w, i, j, k] = std::array::from_fn(|i| values[DOF + 3 + i]);
        let tip = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        let poses = self.tree.configuration(&zeta).world_poses();
        let bodies = BODIES.iter().zip(poses).map(|(body, pose)| {
            let turn = Rotation3::from_matrix_unchecked(pose.R);
            let turn = UnitQuaternion::from_rotation_matrix(&turn);
            (format!("{body:?}"), pose.r, turn)
        });
        let mut transforms = Vec::new();
        for (frame, at, turn) in bodies.chain([("tip".into(), at, tip)]) {
            bytes(&mut transforms, 1, &transform(t, &frame, at, turn));
        }
        self.write(self.poses, &transforms)?;
        for k in 0..self.topics.len() {
            let topic = &mut self.topics[k];
            for column in &topic.columns {
                *column.of(&mut topic.message) = if column.is_text {
                    master.text(column.port)?.into()
                } else {
                    master.number(column.port)?.into()
                };
            }
            let (channel, text) = (topic.channel, serde_json::to_vec(&topic.message)?);
            self.write(channel, &text)?;
        }
        self.rows += 1;
        Ok(())
    }

    fn write(&mut self, channel_id: u16, data: &[u8]) -> Result<()> {
        let time = nanoseconds(self.last.unwrap_or_default());
        let header = MessageHeader {
            channel_id,
            sequence: self.rows,
            log_time: time,
            publish_time: time,
        };
        Ok(self.writer.write_to_known_channel(&header, data)?)
    }

    /// Adds the verdict, or the error that ended the run, and completes the file, unless it holds no
    /// row; the time of the last row, s.
    pub fn finish(mut self, end: Result<&Verdict, &Error>) -> Result<Option<f64>> {
        let Some(t) = self.last else { return Ok(None) };
        // Levels of `foxglove.Log`: information, warning, error.
        let texts = match end {
            Err(error) => vec![(4, format!("{error:#}"))],
            Ok(verdict) => {
                let whole = if verdict.is_bad() { "BAD" } else { "good" };
                let found = verdict.findings().iter();
                let found = found.map(|f| (2 + u8::from(f.is_bad), f.text.clone()));
                (found.chain([(2, format!("verdict: {whole}"))])).collect()
            }
        };
        for (level, text) in texts {
            let mut message = Vec::new();
            bytes(&mut message, 1, &timestamp(t));
            message.extend([2 << 3, level]);
            bytes(&mut message, 3, text.as_bytes());
            bytes(&mut message, 4, b"hdrm-fmu");
            self.write(self.log, &message)?;
        }
        self.writer.finish()?;
        self.writer.into_inner().into_inner().commit()?;
        Ok(Some(t))
    }
}

impl Observer for Recorder {
    fn observe(&mut self, master: &Master) -> Result<()> {
        match master.steps().is_multiple_of(self.stride) {
            true => self.add_row(master),
            false => Ok(()),
        }
    }

    fn end(&mut self, master: &Master) -> Result<()> {
        match self.last == Some(master.time()) {
            true => Ok(()),
            false => self.add_row(master),
        }
    }
}

impl Column {
    /// `component.tip.position[2]` is the second element of the array `position` in the object `tip`.
    fn new(system: &System, port: Port) -> Self {
        let name = &system.variable(port).name;
        let element = name
            .strip_suffix(']')
            .and_then(|name| name.rsplit_once('['));
        let element = element.and_then(|(name, k)| Some((name, k.parse::<usize>().ok()? - 1)));
        let (name, index) = element.map_or((&**name, None), |(name, k)| (name, Some(k)));
        Self {
            port,
            is_text: is_text(system, port),
            path: name.split('.').map(String::from).collect(),
            index,
        }
    }

    /// Its place in the component's message, which is made where it is not there yet.
    fn of<'a>(&self, message: &'a mut Value) -> &'a mut Value {
        let field = self.path.iter().fold(message, |at, name| &mut at[name]);
        let Some(k) = self.index else { return field };
        if field.is_null() {
            *field = json!([]);
        }
        let elements = field.as_array_mut().expect("an array");
        elements.resize(elements.len().max(k + 1), Value::Null);
        &mut elements[k]
    }

    /// Adds its field with the unit to the component's schema.
    fn describe(&self, system: &System, schema: &mut Value) {
        let field = self.path.iter().fold(schema, |at, name| {
            at["type"] = "object".into();
            &mut at["properties"][name]
        });
        let unit = system.variable(self.port).unit.as_deref().unwrap_or("1");
        let kind = if self.is_text { "string" } else { "number" };
        *field = match self.index {
            Some(_) => json!({ "type": "array", "items": { "type": kind }, "description": unit }),
            None => json!({ "type": kind, "description": unit }),
        };
    }
}

/// A `foxglove.FrameTransform` of a frame in the world, whose axes are turned z up.
fn transform(t: f64, frame: &str, at: Vector3<f64>, turn: UnitQuaternion<f64>) -> Vec<u8> {
    let up = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let mut to = Vec::new();
    bytes(&mut to, 1, &timestamp(t));
    bytes(&mut to, 2, b"world");
    bytes(&mut to, 3, frame.as_bytes());
    bytes(&mut to, 4, &doubles(&[at.x, -at.z, at.y]));
    bytes(&mut to, 5, &doubles((up * turn).coords.as_slice()));
    to
}

/// Appends a field of Protocol Buffers that has a length.
fn bytes(to: &mut Vec<u8>, number: u8, data: &[u8]) {
    to.push(number << 3 | 2);
    varint(to, data.len() as u64);
    to.extend(data);
}

fn varint(to: &mut Vec<u8>, mut n: u64) {
    while n >= 0x80 {
        to.push(n as u8 | 0x80);
        n >>= 7;
    }
    to.push(n as u8);
}

/// A message of doubles, numbered from 1.
fn doubles(values: &[f64]) -> Vec<u8> {
    let field = |(number, value): (u8, &f64)| {
        let mut field = vec![number << 3 | 1];
        field.extend(value.to_le_bytes());
        field
    };
    (1..).zip(values).flat_map(field).collect()
}

fn timestamp(t: f64) -> Vec<u8> {
    let (time, mut to) = (nanoseconds(t), Vec::new());
    for (number, part) in [(1, time / 1_000_000_000), (2, time % 1_000_000_000)] {
        to.push(number << 3);
        varint(&mut to, part);
    }
    to
}

fn nanoseconds(t: f64) -> u64 {
    (t * 1e9).round() as u64
}
