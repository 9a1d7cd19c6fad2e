//! `--tev`: what the image viewer tev gets, and that a render never depends on it.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use std::net::TcpListener;
use std::thread::{self, JoinHandle};

use photosite::image::Planes;
use photosite::io::exr::read_exr;
use rstest::rstest;

use crate::folder::Folder;
use crate::room::room;

/// What stands in for tev: images by their names, and the number of their complete updates.
type Shown = BTreeMap<String, (Planes, usize)>;

fn listener() -> (TcpListener, u16) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = listener.local_addr().expect("its address").port();
    (listener, port)
}

/// Reads all messages of one connection, by the protocol as tev documents it.
fn viewer() -> (JoinHandle<Shown>, u16) {
    let (listener, port) = listener();
    let read = move || {
        let mut stream = BufReader::new(listener.accept().expect("a connection").0);
        let mut shown = Shown::new();
        let mut length = [0; 4];
        while stream.read_exact(&mut length).is_ok() {
            let mut message = vec![0; u32::from_le_bytes(length) as usize - 4];
            stream.read_exact(&mut message).expect("a whole message");
            take(&mut Message(&message), &mut shown);
        }
        shown
    };
    (thread::spawn(read), port)
}

struct Message<'a>(&'a [u8]);

impl Message<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_first_chunk().expect("long enough");
        self.0 = rest;
        *taken
    }

    fn u8(&mut self) -> u8 {
        self.bytes::<1>()[0]
    }

    fn number(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn name(&mut self) -> String {
        let mut name = Vec::new();
        loop {
            match self.u8() {
                0 => return String::from_utf8(name).expect("UTF-8"),
                byte => name.push(byte),
            }
        }
    }
}

fn take(message: &mut Message<'_>, shown: &mut Shown) {
    let (kind, _selected, name) = (message.u8(), message.u8(), message.name());
    match kind {
        4 => {
            let [width, height, count] = [message.number(), message.number(), message.number()];
            let names: Vec<String> = (0..count).map(|_| message.name()).collect();
            shown.insert(name, (Planes::zeros(width, height, names), 0));
        }
        6 => {
            let (image, updates) = shown.get_mut(&name).expect("an image that was made before");
            let count = message.number();
            let names: Vec<String> = (0..count).map(|_| message.name()).collect();
            let [left, top, width, height] = std::array::from_fn(|_| message.number());
            let mut places = || (0..count).map(|_| u64::from_le_bytes(message.bytes()) as usize).collect::<Vec<_>>();
            let (offsets, strides) = (places(), places());
            let numbers = message.0.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four")));
            let numbers: Vec<f32> = numbers.collect();
            let row = image.width();
            for (number, name) in names.iter().enumerate() {
                let channel = image.channels_mut().iter_mut().find(|channel| channel.name == *name).expect("a channel");
                for pixel in 0..width * height {
                    let (x, y) = (left + pixel % width, top + pixel / width);
                    channel.data[y * row + x] = numbers[offsets[number] + strides[number] * pixel];
                }
            }
            *updates += usize::from(top + height == image.height());
        }
        _ => panic!("a message of kind {kind}"),
    }
}

fn exr(folder: &Folder, name: &str) -> Planes {
    let file = BufReader::new(std::fs::File::open(folder.path(name)).expect(name));
    read_exr(file).expect(name).planes
}

/// Files of a second render, and development anew, are the second route.
#[rstest]
#[case::whole("", "")]
#[case::strips("--film-memory 0.00004", "")]
#[case::mono("", "--set sensor.preset=\"sony-imx249-mono\" --set sensor.resolution_px=[32,24]")]
#[case::region("", "--set exposure.region_px=[4,2,16,12]")]
fn tev_shows_in_the_end_what_the_files_hold(#[case] how: &str, #[case] what: &str) {
    let folder = room("[render]\nsamples_per_pixel = 8\n");
    let (viewer, port) = viewer();
    let outcome = folder.succeed(&format!("render capture.toml -o out --tev 127.0.0.1:{port} {how} {what}"));
    assert!(!outcome.stderr.contains("tev"), "{}", outcome.stderr);
    let shown = viewer.join().expect("messages that can be read");
    folder.succeed(&format!("render capture.toml -o alone {what}"));
    assert_eq!(folder.results("out")["raw.dng"], folder.results("alone")["raw.dng"], "rendered as without tev");
    folder.succeed("develop alone/raw.dng -o developed.exr");
    assert_eq!(shown.keys().map(String::as_str).collect::<Vec<_>>(), ["out/electrons", "out/image"]);
    let developed = exr(&folder, "developed.exr");
    assert_same(&shown["out/image"].0, &developed);
    assert_same(&shown["out/electrons"].0, &folder.electrons("alone").mean);
}

/// EXR files have their channels in the order of names.
fn assert_same(shown: &Planes, filed: &Planes) {
    assert_eq!([shown.width(), shown.height()], [filed.width(), filed.height()]);
    assert_eq!(shown.channels().len(), filed.channels().len());
    for channel in filed.channels() {
        assert!(shown.plane(&channel.name) == Some(&channel.data[..]), "{} differs", channel.name);
    }
}

#[test]
fn the_picture_grows() {
    let folder = room("[render]\nsamples_per_pixel = 1500\n");
    let (viewer, port) = viewer();
    folder.succeed(&format!("render capture.toml -o out --tev localhost:{port}"));
    let shown = viewer.join().expect("messages that can be read");
    for (name, (_, updates)) in shown {
        assert!(updates > 1, "{name} was sent {updates} times");
    }
}

/// Each way in which tev can fail: exit status 0, one warning, the same bytes. The buffers of both ends hold less than
/// the picture.
#[test]
fn a_render_goes_on_without_tev() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let large = "--set sensor.resolution_px=[1000,800]";
    folder.succeed(&format!("render capture.toml -o alone {large}"));
    let expected = &folder.results("alone")["raw.dng"];
    let rendered = |address: &str, reason: &str| {
        let arguments = format!("render capture.toml -o out --force --tev {address} {large}");
        let outcome = folder.succeed(&arguments);
        let said = outcome.stderr.lines().filter(|line| line.starts_with("warning:") && line.contains("tev"));
        let said: Vec<&str> = said.collect();
        assert_eq!(said.len(), 1, "{}", outcome.stderr);
        let wanted = format!("warning: tev at {address} no longer shows the render, which continues without it: ");
        assert!(said[0].starts_with(&wanted) && said[0].contains(reason), "{}", said[0]);
        assert_eq!(&folder.results("out")["raw.dng"], expected);
    };
    // Nobody listens at a port that was just given up.
    let port = listener().1;
    rendered(&format!("127.0.0.1:{port}"), "refused");
    let quiet = folder.succeed(&format!("render capture.toml -o quiet --quiet --tev 127.0.0.1:{port}"));
    assert_eq!(quiet.stderr, "");
    rendered("nowhere.invalid:14158", "");

    let (hangs_up, port) = listener();
    let hanging = thread::spawn(move || {
        let (mut stream, _) = hangs_up.accept().expect("a connection");
        stream.read_exact(&mut [0; 10]).expect("a message that begins");
    });
    rendered(&format!("127.0.0.1:{port}"), "(os error");
    hanging.join().expect("it came");

    let (silent, port) = listener();
    let waiting = thread::spawn(move || silent.accept().expect("a connection").0);
    rendered(&format!("127.0.0.1:{port}"), "it has not taken the last picture within 5 s");
    waiting.join().expect("it came");
}

#[rstest]
#[case("14158")]
#[case("localhost")]
#[case(":14158")]
#[case("localhost:0")]
#[case("localhost:65536")]
fn an_address_without_host_or_port_is_wrong_usage(#[case] address: &str) {
    let folder = room("");
    let wanted = ["--tev <HOST:PORT>", "write a host and a port, for example 127.0.0.1:14158"];
    folder.fail(&format!("render capture.toml -o out --tev {address}"), 2, &wanted);
}
