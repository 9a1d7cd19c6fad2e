//! The server: connections, and which request is answered by whom.

use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Limited};
use hyper::body::Incoming;
use hyper::header::{HeaderValue, LOCATION};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use serde::Deserialize;
use serde_json::json;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, oneshot};

use super::access::Access;
use super::answer::{Answer, Failure, done, of_bytes, of_json, refused};
use super::controls::{self, Control};
use super::exposer::Exposer;
use super::query::Query;
use super::source::Source;
use super::tracer::{Outside, Tracer};
use super::{events, page};
use crate::capture::Capture;
use crate::pipeline::FilmMemory;
use crate::{Error, Result};

/// Connections at the same time; others wait.
const CONNECTIONS: usize = 64;
/// Within this time a connection has to say what it wants.
const PATIENCE: Duration = Duration::from_secs(10);
/// Pictures that are made, or wait to be sent, at the same time.
const PICTURES: usize = 8;
/// Most bytes of what the page posts.
const POSTED: usize = 64 << 10;

/// What is to be viewed, and how.
pub struct View {
    /// The capture.
    pub capture: Capture,
    /// What it is called.
    pub name: String,
    /// The address to listen at: this machine's own unless others shall see it.
    pub host: IpAddr,
    /// The port; 0 for any that is free.
    pub port: u16,
    /// Memory for the film.
    pub film_memory: FilmMemory,
    /// A folder for the checkpoint of a trace that is stopped.
    pub checkpoint: Option<PathBuf>,
}

/// What all connections share.
struct Shared {
    access: Access,
    name: String,
    controls: Vec<Control>,
    tracer: Arc<Tracer>,
    exposer: Exposer,
    pictures: Arc<Semaphore>,
}

/// What the page posts to `trace`.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
enum Order {
    Pause,
    Continue,
    Stop,
    Start {
        #[serde(default)]
        changes: Vec<String>,
    },
}

/// Serves the page until the program is asked to end. `ready` gets its address.
///
/// # Errors
///
/// An address that cannot be listened at; that the program was asked to end, with how the work goes on.
pub fn serve(view: View, outside: &Outside, ready: impl FnOnce(&str)) -> Result<()> {
    let View { capture, name, host, port, film_memory, checkpoint } = view;
    let tracer = Tracer::new(Arc::clone(outside), film_memory, checkpoint);
    let shared = Arc::new(Shared {
        access: Access::new()?,
        name,
        controls: controls::all(),
        tracer: Arc::clone(&tracer),
        exposer: Exposer::new(),
        pictures: Arc::new(Semaphore::new(PICTURES)),
    });
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|reason| cannot(&format!("start the server: {reason}")))?;
    runtime.block_on(async move {
        let address = SocketAddr::new(host, port);
        let listener = TcpListener::bind(address).await;
        let listener = listener.map_err(|reason| cannot(&format!("listen at {address}: {reason}")))?;
        let bound = listener.local_addr().map_err(|reason| cannot(&format!("listen at {address}: {reason}")))?;
        let (tell, ended) = oneshot::channel();
        let tracing = std::thread::Builder::new().name("trace".to_owned());
        let tracing = tracing.spawn(move || {
            // Nobody hears it where the server has ended before.
            let _ = tell.send(tracer.run(&capture));
        });
        tracing.map_err(|reason| cannot(&format!("start a thread: {reason}")))?;
        ready(&format!("http://{bound}/{}/", shared.access.token()));
        tokio::select! {
            never = accept(listener, shared) => match never {},
            error = ended => Err(error.unwrap_or_else(|_| cannot("trace: its thread has ended"))),
        }
    })
}

fn cannot(what: &str) -> Error {
    Error::Resources { message: format!("cannot {what}"), help: None }
}

async fn accept(listener: TcpListener, shared: Arc<Shared>) -> Infallible {
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let place = Arc::clone(&places).acquire_owned().await;
        let Ok((stream, _)) = listener.accept().await else {
            // There may be too many open files: others will be closed.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let shared = Arc::clone(&shared);
        tokio::spawn(async move {
            let _place = place;
            let service = service_fn(|request| {
                let shared = Arc::clone(&shared);
                async move { Ok::<_, Infallible>(answer(request, shared).await) }
            });
            let mut connection = http1::Builder::new();
            connection.timer(TokioTimer::new()).header_read_timeout(PATIENCE);
            // A connection that breaks is of no concern to others.
            let _ = connection.serve_connection(TokioIo::new(stream), service).await;
        });
    }
}

async fn answer(request: Request<Incoming>, shared: Arc<Shared>) -> Answer {
    let path = match shared.access.path(&request) {
        Ok(Some(path)) => path.to_owned(),
        Ok(None) => {
            let mut answer = refused(StatusCode::PERMANENT_REDIRECT, "the address ends with a slash");
            if let Ok(address) = HeaderValue::from_str(&format!("/{}/", shared.access.token())) {
                answer.headers_mut().insert(LOCATION, address);
            }
            return answer;
        }
        Err(refusal) => return refused(StatusCode::FORBIDDEN, refusal.0),
    };
    let answered = match (request.method(), path.as_str()) {
        (&Method::GET, "about") => Ok(about(&shared)),
        (&Method::GET, "events") => Ok(events::stream(shared.tracer.status().subscribe())),
        (&Method::GET, "picture") => picture(request.uri().query().unwrap_or_default(), &shared).await,
        (&Method::POST, "trace") => order(request, &shared).await,
        (&Method::GET, name) => Ok(page::file(name)),
        (_, _) => Ok(refused(StatusCode::METHOD_NOT_ALLOWED, "this is asked for in another way")),
    };
    answered.unwrap_or_else(|failure| failure.answer())
}

fn about(shared: &Shared) -> Answer {
    of_json(&json!({
        "version": env!("CARGO_PKG_VERSION"),
        "inputs": [{ "name": shared.name, "kind": "scene" }],
        "controls": shared.controls,
    }))
}

async fn picture(text: &str, shared: &Arc<Shared>) -> Result<Answer, Failure> {
    let query = Query::parse(text, &shared.controls)?;
    let busy = || Failure::new(StatusCode::SERVICE_UNAVAILABLE, "too many pictures are asked for at the same time");
    let place = Arc::clone(&shared.pictures).try_acquire_owned().map_err(|_| busy())?;
    let shared = Arc::clone(shared);
    let made = tokio::task::spawn_blocking(move || {
        let _place = place;
        let _way = shared.tracer.make_way();
        let lit = shared.tracer.lit();
        let lit = lit.ok_or_else(|| Failure::new(StatusCode::CONFLICT, "there is no light yet"))?;
        shared.exposer.picture(&Source::Traced(lit), &query)
    });
    let failed = |_| Failure::new(StatusCode::INTERNAL_SERVER_ERROR, "photosite has a mistake, please report it");
    Ok(of_bytes("application/octet-stream", made.await.map_err(failed)??))
}

async fn order(request: Request<Incoming>, shared: &Shared) -> Result<Answer, Failure> {
    let posted = Limited::new(request.into_body(), POSTED).collect().await;
    let posted = posted.map_err(|_| Failure::new(StatusCode::PAYLOAD_TOO_LARGE, "this is too long"))?.to_bytes();
    let order = serde_json::from_slice(&posted);
    match order.map_err(|reason| Failure::new(StatusCode::BAD_REQUEST, format!("this is no order: {reason}")))? {
        Order::Pause => shared.tracer.pause(true),
        Order::Continue => shared.tracer.pause(false),
        Order::Stop => shared.tracer.stop(),
        Order::Start { changes } => shared.tracer.start(changes),
    }
    Ok(done())
}
