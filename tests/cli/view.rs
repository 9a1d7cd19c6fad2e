//! `photosite view`: what the page gets is what the command writes, and who has no token gets nothing.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::room::room;

/// A server that ends with the test.
struct Server {
    process: Child,
    /// Address and port, and the path of the page.
    host: String,
    path: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// An image as it is sent: its description and its values.
struct SentImage {
    facts: Value,
    values: Vec<u8>,
}

impl SentImage {
    /// Digital numbers of a raw image.
    fn numbers(&self) -> Vec<u16> {
        self.values.as_chunks().0.iter().map(|&bytes| u16::from_le_bytes(bytes)).collect()
    }
}

impl Server {
    fn start(folder: &Folder, arguments: &str) -> Self {
        let mut process = folder.command(&format!("view {arguments}")).stdout(Stdio::piped()).spawn().expect("started");
        let mut address = String::new();
        BufReader::new(process.stdout.take().expect("piped")).read_line(&mut address).expect("an address");
        let address = address.trim().strip_prefix("http://").expect(&address);
        let (host, path) = address.split_once('/').expect("a path");
        Self { process, host: host.to_owned(), path: format!("/{path}") }
    }

    /// Status and body.
    fn ask(&self, path: &str, headers: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).expect("a connection");
        stream.set_read_timeout(Some(Duration::from_secs(120))).expect("a time");
        write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("headers");
        let status = std::str::from_utf8(&answer[9..12]).expect("digits").parse().expect("a status");
        (status, answer.split_off(end + 4))
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        self.ask(&format!("{}{path}", self.path), &format!("Host: {}\r\n", self.host))
    }

    /// The first event of a phase.
    fn wait_for(&self, phase: &str) -> Value {
        let mut stream = TcpStream::connect(&self.host).expect("a connection");
        stream.set_read_timeout(Some(Duration::from_secs(120))).expect("a time");
        write!(stream, "GET {}events HTTP/1.1\r\nHost: {}\r\n\r\n", self.path, self.host).expect("sent");
        for line in BufReader::new(stream).lines() {
            let line = line.expect("an event in time");
            let Some(event) = line.strip_prefix("data: ") else { continue };
            let status: Value = serde_json::from_str(event).expect("JSON");
            assert_ne!(status["phase"], "failed", "{status}");
            if status["phase"] == phase {
                return status;
            }
        }
        panic!("the events end before the phase {phase}");
    }

    fn image(&self, query: &str) -> SentImage {
        let (status, body) = self.get(&format!("picture?{query}"));
        assert_eq!(status, 200, "{query}: {}", String::from_utf8_lossy(&body));
        let length = u32::from_le_bytes(body[..4].try_into().expect("four bytes")) as usize;
        let facts = serde_json::from_slice(&body[4..4 + length]).expect("JSON");
        SentImage { facts, values: body[4 + length..].to_vec() }
    }
}

/// Codes of a PNG file.
fn codes(folder: &Folder, name: &str) -> Vec<u8> {
    image::open(folder.path(name)).expect(name).to_rgb8().into_raw()
}

const SETTINGS: &str =
    "[render]\nsamples_per_pixel = 4\nseed = 3\n[output]\nraw = ['dng', 'npy']\nirradiance = true\nideal = true\n";

/// The image of settings, and what the command is told for the same.
const CASES: [(&str, &str); 10] = [
    ("", ""),
    ("exposure.time_s=0.002", "--set exposure.time_s=0.002"),
    ("exposure.auto=true", "--set exposure.auto=true"),
    ("exposure.gain_db=6&exposure.temperature_c=60", "--set exposure.gain_db=6 --set exposure.temperature_c=60"),
    ("render.seed=9", "--set render.seed=9"),
    ("exposure.stages_off=read-noise%2Cshot-noise", "--set exposure.stages_off=[\"read-noise\",\"shot-noise\"]"),
    ("sensor.preset=sony-imx249-color", "--set sensor.preset=sony-imx249-color"),
    (
        "develop.white_balance=temperature&develop.temperature_k=3200",
        "--set develop.white_balance=temperature --set develop.temperature_k=3200",
    ),
    (
        "develop.demosaic=bilinear&develop.tone_curve=filmic",
        "--set develop.demosaic=bilinear --set develop.tone_curve=filmic",
    ),
    ("develop.sharpening=1.5&exposure.time_s=0.01", "--set develop.sharpening=1.5 --set exposure.time_s=0.01"),
];

/// Effects of CCDs are offered for CCDs alone, as stages and as planes.
#[test]
fn effects_are_those_of_the_sensor_that_is_chosen() {
    let folder = room(SETTINGS);
    let server = Server::start(&folder, "capture.toml");
    server.wait_for("done");
    for (preset, has, has_not) in [
        ("generic-cmos-color", "dark-current", &["smear", "blooming", "vertical-transfer", "photon-counting"][..]),
        ("onsemi-kai-02170-mono", "smear", &["row-noise", "column-noise", "low-gain-read-noise", "photon-counting"]),
        ("swissspad2", "photon-counting", &["smear", "blooming", "read-noise"]),
    ] {
        let facts = server.image(&format!("sensor.preset={preset}")).facts;
        let names = |key: &str| -> Vec<&str> {
            facts[key].as_array().expect(key).iter().filter_map(serde_json::Value::as_str).collect()
        };
        let (stages, planes) = (names("stages"), names("planes"));
        assert!(stages.contains(&has), "{preset}: {stages:?}");
        assert!(has_not.iter().all(|stage| !stages.contains(stage)), "{preset}: {stages:?}");
        assert_eq!(planes.contains(&"noise:smear_e"), has == "smear", "{preset}: {planes:?}");
        assert!(planes.contains(&"noise:photo_electrons_e"), "{preset}: {planes:?}");
    }
}

/// Light that is traced for the page, coarse first, and light that a render has stored.
#[rstest]
#[case::traced("capture.toml")]
#[case::stored("out")]
fn images_have_the_bytes_of_the_command(#[case] input: &str) {
    let folder = room(SETTINGS);
    folder.succeed("render capture.toml -o out");
    let server = Server::start(&folder, input);
    server.wait_for(if input == "out" { "stored" } else { "done" });
    let [width, height] = [0, 1].map(|i| folder.report("out")["sensor"]["resolution_px"][i].as_u64().expect("pixels"));
    for (i, (query, options)) in CASES.into_iter().enumerate() {
        // Another sensor has the pixels of the light.
        let pixels = if query.contains("preset") {
            format!("--set sensor.resolution_px=[{width},{height}]")
        } else {
            String::new()
        };
        folder.succeed(&format!("expose out -o exposed-{i} {options} {pixels}"));
        let image = server.image(query);
        assert!(image.values == codes(&folder, &format!("exposed-{i}/image.png")), "{query}");
        assert_eq!(
            (&image.facts["channels"], &image.facts["type"]),
            (&serde_json::json!(["R", "G", "B"]), &"u8".into())
        );
        let raw = server.image(&format!("plane=raw&{query}"));
        let file = folder.raw(&format!("exposed-{i}/raw.dng"));
        assert!(raw.numbers() == file.data, "{query}: digital numbers");
        assert_eq!(raw.facts["raw"]["white_dn"], file.white_level_dn, "{query}");
    }
    // Later frames have noise of their own.
    folder.succeed("expose out -o frames --frames 3");
    folder.succeed("develop frames/raw-0002.dng -o frame.png");
    assert!(server.image("frame=2").values == codes(&folder, "frame.png"));
    assert_eq!(server.get("picture?frame=5000").0, 400);
}

/// Frames whose gain follows from the frames before them, of light that is traced for the page and of stored light.
#[rstest]
#[case::traced(&format!("capture.toml {GAIN_CONTROL}"), "done")]
#[case::stored("out", "stored")]
fn frames_follow_gain_control_as_those_of_the_command(#[case] input: &str, #[case] phase: &str) {
    let folder = room(SETTINGS);
    folder.succeed(&format!("render capture.toml -o out {GAIN_CONTROL}"));
    let server = Server::start(&folder, input);
    server.wait_for(phase);
    for frame in [2, 0, 1] {
        let shown = server.image(&format!("plane=raw&frame={frame}"));
        assert!(shown.numbers() == folder.raw(&format!("out/raw-{frame:04}.dng")).data, "frame {frame}");
    }
    let gain_db = |frame: u32| {
        server.image(&format!("plane=raw&frame={frame}")).facts["settings"]["exposure.gain_db"].as_f64().expect("dB")
    };
    let gains = [0, 1, 2].map(gain_db);
    assert!(gains[0] < gains[1] && gains[1] < gains[2], "{gains:?} dB of light that is too weak for the target");
}

const GAIN_CONTROL: &str =
    "--set exposure.time_s=0.00002 --set exposure.frames=3 --set exposure.gain_control={target=0.5}";

#[test]
fn planes_and_pixels_are_those_of_the_files() {
    let folder = room(&format!("{SETTINGS}truth = ['depth', 'normal']\nnoise = ['read_noise_e']\n"));
    folder.succeed("render capture.toml -o out");
    let server = Server::start(&folder, "capture.toml out/raw.dng");
    server.wait_for("done");
    let floats = |image: &SentImage| -> Vec<f32> {
        image.values.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect()
    };
    let same = |a: &[f32], b: &[f32]| a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits()));
    let electrons = folder.electrons("out");
    let of_page = server.image("plane=electrons:G");
    assert_eq!(of_page.facts["unit"], "e⁻");
    assert!(same(&floats(&of_page), electrons.mean.plane("G").expect("green")));
    let truth = photosite::io::exr::read_exr_file(&folder.path("out/truth.exr")).expect("truth").planes;
    let depth = truth.channels().iter().find(|channel| channel.name.to_lowercase().contains("depth")).expect("depth");
    assert!(same(&floats(&server.image("plane=truth:depth")), &depth.data));
    let noise = photosite::io::exr::read_exr_file(&folder.path("out/noise.exr")).expect("noise").planes;
    assert!(same(&floats(&server.image("plane=noise:read_noise_e")), &noise.channels()[0].data));
    let planes = &of_page.facts["planes"];
    for plane in planes.as_array().expect("planes") {
        let plane = plane.as_str().expect("a name").replace(' ', "%20");
        let image = server.image(&format!("plane={plane}"));
        let count = |key: &str| image.facts[key].as_u64().expect("a number") as usize;
        let bytes = match image.facts["type"].as_str() {
            Some("u8") => 1,
            Some("u16") => 2,
            _ => 4,
        };
        let channels = image.facts["channels"].as_array().expect("channels").len();
        assert_eq!(image.values.len(), count("width") * count("height") * channels * bytes, "{plane}");
    }
    // A pixel, and the raw file as the second input.
    let (status, pixel) = server.get("pixel?x=3&y=2");
    let pixel: Value = serde_json::from_slice(&pixel).expect("JSON");
    assert_eq!(status, 200);
    let width = electrons.mean.width();
    let green = pixel["electrons"].as_array().expect("electrons").iter().find(|e| e[0] == "G").expect("green");
    assert_eq!(green[1].as_f64(), Some(f64::from(electrons.mean.plane("G").expect("green")[2 * width + 3])));
    let file = folder.raw("out/raw.dng");
    assert_eq!(pixel["raw"][0][1], file.data[2 * file.width + 3]);
    let at = (2 * width + 3) * 3;
    let developed: Vec<u64> = (0..3).map(|c| pixel["developed"][c][1].as_f64().expect("a code") as u64).collect();
    assert_eq!(developed, codes(&folder, "out/image.png")[at..at + 3].iter().map(|&c| c.into()).collect::<Vec<u64>>());
    assert!(server.image("input=1").values == codes(&folder, "out/image.png"));
    assert_eq!(server.get("picture?input=2").0, 404);
    assert_eq!(server.get("picture?input=1&exposure.time_s=1").0, 409, "a raw file is exposed already");
    // What was changed is what the command takes.
    let (_, text) = server.get("capture?exposure.time_s=0.002&develop.tone_curve=filmic");
    let text = String::from_utf8(text).expect("UTF-8");
    let changes: toml::Table = text.parse().expect("TOML");
    assert_eq!(changes["exposure"]["time_s"].as_float(), Some(0.002));
    assert_eq!(changes["develop"]["tone_curve"].as_str(), Some("filmic"));
}

#[test]
fn strangers_get_nothing() {
    let folder = room(SETTINGS);
    folder.succeed("render capture.toml -o out");
    let server = Server::start(&folder, "out/raw.dng");
    assert_eq!(server.get("").0, 200);
    let host = format!("Host: {}\r\n", server.host);
    assert_eq!(server.ask("/", &host).0, 403);
    assert_eq!(server.ask("/00000000000000000000000000000000/", &host).0, 403);
    assert_eq!(server.ask(&server.path, "Host: evil.example\r\n").0, 403);
    assert_eq!(server.ask(&server.path, &format!("{host}Origin: http://evil.example\r\n")).0, 403);
    for path in ["../capture.toml", "%2e%2e/capture.toml", "capture.toml", "/etc/passwd", "page/view.js"] {
        assert_eq!(server.get(path).0, 404, "{path}");
    }
    for query in ["sensor.preset=%2Fetc%2Fpasswd", "scene.geometry=x", "develop.raw=x", "frame=x", "plane"] {
        assert_eq!(server.get(&format!("picture?{query}")).0, 400, "{query}");
    }
    folder.fail("view out nothing.toml", 1, &["nothing.toml"]);
    folder.fail("view capture.toml capture.toml", 2, &["one scene can be traced at a time"]);
}

/// Files of a stranger's folder may be links to anything: they are refused by their names, not served.
#[cfg(unix)]
#[rstest]
#[case::image("set", "camera/000000/image.png", "image?input=0")]
#[case::small_image("set", "camera/000000/image.png", "image?input=0&width=160")]
#[case::folder("set", "camera/000000", "image?input=0")]
#[case::boxes("set", "camera/000000/objects.json", "overlays?input=0")]
#[case::report("set", "camera/000000/capture.json", "overlays?input=0")]
#[case::light("set", "camera/000000/electrons.exr", "picture?input=0")]
#[case::light_of_report("set", "camera/000000/capture.json", "picture?input=0")]
#[case::truth("set/camera/000000", "truth.exr", "picture?plane=truth:depth")]
#[case::ideal("set/camera/000000", "ideal.exr", "picture?plane=ideal")]
fn links_out_of_the_sandbox_are_not_served(#[case] input: &str, #[case] linked: &str, #[case] query: &str) {
    let more = "[output]\ntruth = ['depth', 'instance']\nobjects = true\nideal = true\nelectrons = true\n";
    let folder = room(&format!("[render]\nsamples_per_pixel = 1\n{more}"));
    folder.add("set.toml", "capture = 'capture.toml'\nframes = 1\n");
    folder.succeed("dataset set.toml -o set -q");
    let outside = tempfile::tempdir().expect("a folder");
    let server = Server::start(&folder, &format!("{input} --sandbox ."));
    assert_eq!(server.get(query).0, 200);
    drop(server);
    // What is there from the beginning, and what comes later.
    let (from, to) = (folder.path(input).join(linked), outside.path().join("private"));
    let link = || std::fs::rename(&from, &to).and_then(|()| std::os::unix::fs::symlink(&to, &from)).expect("linked");
    let server = Server::start(&folder, &format!("{input} --sandbox ."));
    link();
    let (status, body) = server.get(query);
    let text = String::from_utf8_lossy(&body);
    let name = from.file_name().expect("a name").to_string_lossy();
    assert!(status >= 400 && text.contains("not in the sandbox") && text.contains(&*name), "{status}: {text}");
}

/// A hundred connections that say nothing keep nobody out.
#[test]
fn who_says_nothing_gives_way() {
    let folder = room(SETTINGS);
    folder.succeed("render capture.toml -o out");
    let server = Server::start(&folder, "out/raw.dng");
    let silent: Vec<TcpStream> = (0..100).map(|_| TcpStream::connect(&server.host).expect("a connection")).collect();
    // Others dwell on their first word, or are refused and stay.
    let mut slow = Vec::new();
    for text in ["G", "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"].repeat(50) {
        let mut stream = TcpStream::connect(&server.host).expect("a connection");
        stream.write_all(text.as_bytes()).expect("sent");
        slow.push(stream);
    }
    let start = std::time::Instant::now();
    assert_eq!(server.get("about").0, 200);
    // Well before the ten seconds in which each of them may say what it wants.
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    drop((silent, slow));
}
