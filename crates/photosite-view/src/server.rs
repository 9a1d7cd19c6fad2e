//! Server of the view: its connections, and the answer of each request.

use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONNECTION, HeaderValue, LOCATION};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use tokio::net::TcpListener;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot, watch};
use tokio::time::timeout;

use super::access::Access;
use super::answer::{Answer, Failure, done, of_bytes, of_json, refused};
use super::changes::{for_trace, tables, to_toml};
use super::connection::Connection;
use super::controls::{self, Control};
use super::exposer::Exposer;
use super::guests::Guests;
use super::query::{MOST_FRAMES, Query};
use super::sheet::ContactSheet;
use super::source::{ImageSource, Input, NumberedLight};
use super::status::{Phase, Status};
use super::tracer::{Outside, Tracer, Wanted};
use super::{events, page};
use photosite_capture::Capture;
use photosite_core::{Error, Result};
use photosite_pipeline::{FilmMemory, SensorCard};

/// Most connections at the same time; those that have not shown the token give way to others.
const CONNECTIONS: usize = 64;
/// Most pages that are told how far the light is, at the same time: each keeps a connection.
const LISTENERS: usize = 32;
/// Time within which a connection has to say what it wants, and to take some of what it gets.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most images that are made, or wait to be sent, at the same time.
const IMAGES: usize = 8;
/// Most bytes of a request body.
const POSTED: usize = 64 << 10;

/// View to serve: inputs, address and memory.
pub struct View {
    /// Inputs with the name that the page shows, and that of a command line; of scenes at most one.
    pub inputs: Vec<(String, Input)>,
    /// Card that exposes and develops; `None` for the processor.
    pub card: Option<Arc<SensorCard>>,
    /// The address to listen at: this machine's own unless others shall see it.
    pub host: IpAddr,
    /// The port; 0 for any that is free.
    pub port: u16,
    /// Memory for the film.
    pub film_memory: FilmMemory,
    /// A folder for the checkpoint of a trace that is stopped.
    pub checkpoint: Option<PathBuf>,
    /// The token of the address, where a page shall find a server again that was started anew; drawn where it is left
    /// out.
    pub token: Option<String>,
}

/// An input that is being viewed.
enum Viewed {
    /// The light of the tracer, and the capture as it was given.
    Scene(Box<Capture>),
    /// An input that does not change.
    Stored(ImageSource),
    /// An image of the data set.
    InSheet(usize),
}

/// State that all connections share.
struct Shared {
    access: Access,
    inputs: Vec<(String, &'static str, Viewed)>,
    controls: Vec<Control>,
    /// Tracer of the scene, if there is one.
    tracer: Option<Arc<Tracer>>,
    status: watch::Sender<Status>,
    exposer: Exposer,
    images: Arc<Semaphore>,
    /// Name of the inputs, in a few words.
    name: String,
    /// Contact sheet of the data set, if there is one.
    sheet: Option<ContactSheet>,
}

/// Order that the page posts to `trace`.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
enum Order {
    Pause {},
    Continue {},
    Stop {},
    Start {
        #[serde(default)]
        changes: Map<String, Value>,
        #[serde(default)]
        frame: u32,
    },
}

/// Serves the page until the program is asked to end. `ready` gets its address.
///
/// # Errors
///
/// An address that cannot be listened at; that the program was asked to end, with how the work goes on.
pub fn serve(view: View, outside: &Outside, ready: impl FnOnce(&str)) -> Result<()> {
    let View { card, inputs, host, port, film_memory, checkpoint, token } = view;
    let status = watch::Sender::new(Status::new(Phase::Stored));
    let (mut scene, mut sheet) = (None, None);
    let mut viewed = Vec::new();
    let names: Vec<String> = inputs.iter().map(|(name, _)| name.clone()).collect();
    let of_several = names.len() > 1;
    for (name, input) in inputs {
        let kind = input.kind();
        let input = match input {
            Input::Scene(capture) if scene.is_none() => {
                scene = Some(capture.clone());
                Viewed::Scene(capture)
            }
            Input::Scene(_) => {
                let help = "render the other one, and give its folder".into();
                let message = "only one scene can be traced at a time, and there are two".to_owned();
                return Err(Error::Usage { message, help: Some(help) });
            }
            Input::Light(light) => Viewed::Stored(ImageSource::of_light(light)),
            Input::File(file) => Viewed::Stored(ImageSource::File(Arc::new(file))),
            Input::DataSet(_) if of_several => {
                let help = "give it alone: any two of its images can be compared on the page".into();
                return Err(Error::Usage { message: format!("{name} is a data set"), help: Some(help) });
            }
            Input::DataSet(set) => {
                let (set, sandbox) = *set;
                let set = ContactSheet::new(set, sandbox);
                viewed.extend(set.names().enumerate().map(|(number, name)| (name, "picture", Viewed::InSheet(number))));
                sheet = Some(set);
                continue;
            }
        };
        viewed.push((name, kind, input));
    }
    let tracer = scene.as_ref().map(|_| Tracer::new(Arc::clone(outside), status.clone(), film_memory, checkpoint));
    let shared = Arc::new(Shared {
        access: token.map_or_else(Access::random, Access::with_token)?,
        inputs: viewed,
        controls: controls::all(),
        tracer: tracer.clone(),
        status,
        exposer: Exposer::new(card)?,
        images: Arc::new(Semaphore::new(IMAGES)),
        name: names.join(" and "),
        sheet,
    });
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|reason| cannot(&format!("start the server: {reason}")))?;
    runtime.block_on(async move {
        let address = SocketAddr::new(host, port);
        let listener = TcpListener::bind(address).await;
        let listener = listener.map_err(|reason| cannot(&format!("listen at {address}: {reason}")))?;
        let bound = listener.local_addr().map_err(|reason| cannot(&format!("listen at {address}: {reason}")))?;
        let (tell, ended) = oneshot::channel();
        let tracing = move || {
            let Some((tracer, capture)) = tracer.zip(scene) else { return };
            // Nobody hears it where the server has ended before.
            let _ = tell.send(tracer.run(&capture));
        };
        let begun = std::thread::Builder::new().name("trace".to_owned()).spawn(tracing);
        begun.map_err(|reason| cannot(&format!("start a thread: {reason}")))?;
        let has_tracer = shared.tracer.is_some();
        ready(&format!("http://{bound}/{}/", shared.access.token()));
        tokio::select! {
            never = accept(listener, shared) => match never {},
            error = ended, if has_tracer => Err(error.unwrap_or_else(|_| cannot("trace: its thread has ended"))),
        }
    })
}

fn cannot(what: &str) -> Error {
    Error::Resources { message: format!("cannot {what}"), help: None }
}

async fn accept(listener: TcpListener, shared: Arc<Shared>) -> Infallible {
    let mut guests = Guests::new(CONNECTIONS);
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // There may be too many open files: others will be closed.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let (place, guest) = guests.admit().await;
        let shared = Arc::clone(&shared);
        tokio::spawn(async move {
            let _place = place;
            let service = service_fn(|request| {
                let shared = Arc::clone(&shared);
                if shared.access.path(&request).is_ok() {
                    guest.is_known();
                }
                async move { Ok::<_, Infallible>(answer(request, shared).await) }
            });
            let mut connection = http1::Builder::new();
            connection.timer(TokioTimer::new()).header_read_timeout(PATIENCE);
            // A connection that breaks is of no concern to others.
            let stream = TokioIo::new(Connection::new(stream, PATIENCE));
            tokio::select! {
                _ = connection.serve_connection(stream, service) => {}
                () = guest.gives_way() => {}
            }
        });
    }
}

async fn answer(request: Request<Incoming>, shared: Arc<Shared>) -> Answer {
    let path = match shared.access.path(&request) {
        Ok(Some(path)) => path.to_owned(),
        Ok(None) => {
            let mut answer = refused(StatusCode::PERMANENT_REDIRECT, "the address must end with a slash");
            if let Ok(address) = HeaderValue::from_str(&format!("/{}/", shared.access.token())) {
                answer.headers_mut().insert(LOCATION, address);
            }
            return answer;
        }
        Err(refusal) => return refused(StatusCode::FORBIDDEN, refusal.0),
    };
    let text = request.uri().query().unwrap_or_default();
    let answered = match (request.method(), path.as_str()) {
        (&Method::GET, "about") => Ok(about(&shared)),
        (&Method::GET, "events") if shared.status.receiver_count() >= LISTENERS => {
            let mut answer = Failure::new(StatusCode::SERVICE_UNAVAILABLE, "too many pages are open").answer();
            // Who only listens asks for nothing else.
            answer.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
            Ok(answer)
        }
        (&Method::GET, "events") => Ok(events::stream(shared.status.subscribe())),
        (&Method::GET, "picture") => {
            let image = |shared: &Shared, source: &ImageSource, query: &Query| shared.exposer.image(source, query);
            let made = made(text, &shared, image).await;
            made.map(|(bytes, place)| sent("application/octet-stream", bytes, place))
        }
        (&Method::GET, "pixel") => {
            let pixel =
                |shared: &Shared, source: &ImageSource, query: &Query| shared.exposer.pixel(source, query, query.pixel);
            made(text, &shared, pixel).await.map(|(pixel, _place)| of_json(&pixel))
        }
        (&Method::GET, "noise") => {
            let noise = |shared: &Shared, source: &ImageSource, query: &Query| shared.exposer.noise(source, query);
            made(text, &shared, noise).await.map(|(noise, _place)| of_json(&json!({ "noise_ratio": noise })))
        }
        (&Method::GET, "capture") => saved(text, &shared).await,
        (&Method::POST, "trace") => order(request, &shared).await,
        (&Method::GET, "sheet") => {
            of_sheet(&shared, |sheet| Ok(sheet.list())).await.map(|(list, _place)| of_json(&list))
        }
        (&Method::GET, "image") => {
            let text = text.to_owned();
            let image = of_sheet(&shared, move |sheet| sheet.image(&text)).await;
            image.map(|((media_type, bytes), place)| sent(media_type, bytes, place))
        }
        (&Method::GET, "overlays") => {
            let text = text.to_owned();
            let overlays = of_sheet(&shared, move |sheet| sheet.overlays(&text)).await;
            overlays.map(|(overlays, _place)| of_json(&overlays))
        }
        (&Method::GET, name) => Ok(page::file(name, shared.sheet.is_some())),
        (_, _) => Ok(refused(StatusCode::METHOD_NOT_ALLOWED, "this needs another method (GET or POST)")),
    };
    answered.unwrap_or_else(|failure| failure.answer())
}

fn about(shared: &Shared) -> Answer {
    let inputs: Vec<Value> =
        shared.inputs.iter().map(|(name, kind, _)| json!({ "name": name, "kind": kind })).collect();
    let (name, has_sheet) = (&shared.name, shared.sheet.is_some());
    of_json(&json!({
        "version": env!("CARGO_PKG_VERSION"), "name": name, "has_sheet": has_sheet, "inputs": inputs, "controls": shared.controls,
    }))
}

fn no_input(number: usize) -> Failure {
    Failure::new(StatusCode::NOT_FOUND, format!("there is no input {number}"))
}

/// Image on its way, and the place that it takes.
struct Sent {
    bytes: Vec<u8>,
    _place: OwnedSemaphorePermit,
}

impl AsRef<[u8]> for Sent {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Bytes whose place is taken until they are sent.
fn sent(media_type: &'static str, bytes: Vec<u8>, place: OwnedSemaphorePermit) -> Answer {
    of_bytes(media_type, Bytes::from_owner(Sent { bytes, _place: place }))
}

/// Makes something of the input that is asked for, on a thread that may take its time; tracing waits meanwhile. The
/// result comes with its place among the images under way.
async fn made<T: Send + 'static>(
    text: &str,
    shared: &Arc<Shared>,
    make: impl FnOnce(&Shared, &ImageSource, &Query) -> Result<T, Failure> + Send + 'static,
) -> Result<(T, OwnedSemaphorePermit), Failure> {
    let query = Query::parse(text, &shared.controls)?;
    aside(shared, move |shared| {
        let _way = shared.tracer.as_deref().map(Tracer::make_way);
        let (.., viewed) = shared.inputs.get(query.input).ok_or_else(|| no_input(query.input))?;
        match viewed {
            Viewed::Stored(source) => make(shared, source, &query),
            Viewed::InSheet(number) => {
                let source = shared.sheet.as_ref().ok_or_else(|| no_input(query.input))?.source(*number)?;
                make(shared, &source, &query)
            }
            Viewed::Scene(_) => {
                let lit = shared.tracer.as_deref().and_then(Tracer::lit);
                let lit = lit.ok_or_else(|| Failure::new(StatusCode::CONFLICT, "there is no light yet"))?;
                make(shared, &ImageSource::Light(lit), &query)
            }
        }
    })
    .await
}

/// Answer of the contact sheet of a data set.
async fn of_sheet<T: Send + 'static>(
    shared: &Arc<Shared>,
    answer: impl FnOnce(&ContactSheet) -> Result<T, Failure> + Send + 'static,
) -> Result<(T, OwnedSemaphorePermit), Failure> {
    let nothing = || Failure::new(StatusCode::NOT_FOUND, "there is nothing at this address: no data set is viewed");
    aside(shared, move |shared| answer(shared.sheet.as_ref().ok_or_else(nothing)?)).await
}

/// Works on a thread that may take its time. The result comes with its place among the images under way.
async fn aside<T: Send + 'static>(
    shared: &Arc<Shared>,
    work: impl FnOnce(&Shared) -> Result<T, Failure> + Send + 'static,
) -> Result<(T, OwnedSemaphorePermit), Failure> {
    let busy = || Failure::new(StatusCode::SERVICE_UNAVAILABLE, "too many images are requested at the same time");
    let place = Arc::clone(&shared.images).try_acquire_owned().map_err(|_| busy())?;
    let shared = Arc::clone(shared);
    let made = tokio::task::spawn_blocking(move || Ok((work(&shared)?, place)));
    let failed = |_| Failure::new(StatusCode::INTERNAL_SERVER_ERROR, "this is a bug in photosite, please report it");
    made.await.map_err(failed)?
}

/// The capture as it is set, as a capture file.
async fn saved(text: &str, shared: &Arc<Shared>) -> Result<Answer, Failure> {
    let query = Query::parse(text, &shared.controls)?;
    let (text, _place) = aside(shared, move |shared| {
        let (name, _, viewed) = shared.inputs.get(query.input).ok_or_else(|| no_input(query.input))?;
        let of_sheet = |number: usize| shared.sheet.as_ref().ok_or_else(|| no_input(query.input))?.source(number);
        let source = match viewed {
            Viewed::Scene(capture) => {
                let tracer = shared.tracer.as_deref();
                let resolution = tracer.and_then(Tracer::lit).map(|lit| lit.light.settings().sensor.resolution);
                let changes = [tracer.map_or_else(Vec::new, Tracer::changes), query.changes(resolution)].concat();
                let table = capture.with(&changes)?.to_table()?;
                // The seed of the page is that of the sensor's noise.
                let has_seed = changes.iter().any(|change| change.starts_with("render.seed="));
                let note = "The seed also draws the noise of the light again, which the page has left as it was.";
                let notes = if has_seed { &[note][..] } else { &[] };
                return Ok(to_toml(name, &table, "render", [capture.overrides(), &changes], notes));
            }
            Viewed::Stored(source) => source.clone(),
            Viewed::InSheet(number) => of_sheet(*number)?,
        };
        match source {
            ImageSource::Light(NumberedLight { light, .. }) => {
                let changes = query.changes(Some(light.settings().sensor.resolution));
                let table = light.with(&changes)?.to_table()?;
                Ok(to_toml(name, &table, "expose", [light.overrides(), &changes], &[]))
            }
            ImageSource::File(_) => {
                let changes = query.changes(None);
                Ok(to_toml(name, &tables(&changes), "develop", [&[], &changes], &[]))
            }
        }
    })
    .await?;
    Ok(of_bytes("application/toml; charset=utf-8", text))
}

async fn order(request: Request<Incoming>, shared: &Shared) -> Result<Answer, Failure> {
    let posted = timeout(PATIENCE, Limited::new(request.into_body(), POSTED).collect()).await;
    let posted = posted.map_err(|_| Failure::new(StatusCode::REQUEST_TIMEOUT, "the command did not arrive in time"))?;
    let posted = posted.map_err(|_| Failure::new(StatusCode::PAYLOAD_TOO_LARGE, "the request is too long"))?.to_bytes();
    let order = serde_json::from_slice(&posted);
    let order =
        order.map_err(|reason| Failure::new(StatusCode::BAD_REQUEST, format!("this is not a command: {reason}")))?;
    let nothing = || Failure::new(StatusCode::CONFLICT, "nothing is traced: the light is read from files");
    let tracer = shared.tracer.as_deref().ok_or_else(nothing)?;
    match order {
        Order::Pause {} => tracer.pause(true),
        Order::Continue {} => tracer.pause(false),
        Order::Stop {} => tracer.stop(),
        Order::Start { frame, .. } if frame >= MOST_FRAMES => {
            let message = format!("frame: {frame} is not below {MOST_FRAMES}");
            return Err(Failure::new(StatusCode::BAD_REQUEST, message));
        }
        Order::Start { changes, frame } => tracer.start(Wanted { changes: for_trace(&changes)?, frame }),
    }
    Ok(done())
}
