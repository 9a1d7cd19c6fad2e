//! The stream of events: the status, at once and whenever it changes.

use std::convert::Infallible;
use std::time::Duration;

use http_body_util::BodyExt;
use http_body_util::channel::Channel;
use hyper::StatusCode;
use hyper::body::Bytes;
use tokio::sync::watch;

use super::answer::{Answer, of_body};
use super::status::Status;

/// Interval of signs of life, by which either side notices that the other is gone.
const HEARTBEAT: Duration = Duration::from_secs(10);
/// Shortest interval between two messages to the page.
const SHORTEST: Duration = Duration::from_millis(100);

/// Stream of the status as server-sent events. Slow readers get the newest status alone: nothing queues up.
pub(super) fn stream(mut status: watch::Receiver<Status>) -> Answer {
    let (mut page, body) = Channel::<Bytes, Infallible>::new(1);
    tokio::spawn(async move {
        loop {
            let now = serde_json::to_string(&*status.borrow_and_update()).expect("plain values");
            if page.send_data(format!("data: {now}\n\n").into()).await.is_err() {
                return;
            }
            tokio::time::sleep(SHORTEST).await;
            loop {
                match tokio::time::timeout(HEARTBEAT, status.changed()).await {
                    Ok(Ok(())) => break,
                    Ok(Err(_)) => return,
                    Err(_) if page.send_data(":\n\n".into()).await.is_err() => return,
                    Err(_) => {}
                }
            }
        }
    });
    of_body(StatusCode::OK, "text/event-stream", body.boxed())
}
