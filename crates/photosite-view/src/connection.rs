//! A connection that does not wait for ever for somebody who reads nothing.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Sleep, sleep};

/// A stream that fails where nothing of what is to be sent is taken for some time.
pub(super) struct Connection {
    stream: TcpStream,
    patience: Duration,
    /// Timer that runs while something waits to be sent.
    waiting: Option<Pin<Box<Sleep>>>,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, patience: Duration) -> Self {
        Self { stream, patience, waiting: None }
    }

    /// Result of sending; sending that has to wait fails in time.
    fn sent<T>(&mut self, context: &mut Context<'_>, sent: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if sent.is_ready() {
            self.waiting = None;
            return sent;
        }
        let patience = self.patience;
        let waiting = self.waiting.get_or_insert_with(|| Box::pin(sleep(patience)));
        ready!(waiting.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "nobody reads what is sent")))
    }
}

impl AsyncRead for Connection {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, to: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, to)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let sent = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.sent(context, sent)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let sent = Pin::new(&mut self.stream).poll_flush(context);
        self.sent(context, sent)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::future::poll_fn;
    use std::io::Read;

    use tokio::net::TcpListener;

    use super::*;

    /// Sends all bytes, and says how it ends.
    async fn send(connection: &mut Connection, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            let sent = poll_fn(|context| Pin::new(&mut *connection).poll_write(context, bytes)).await?;
            bytes = &bytes[sent..];
        }
        Ok(())
    }

    #[test]
    fn who_reads_nothing_is_left_and_who_reads_gets_all() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
            let address = listener.local_addr().expect("bound");
            let connect = || std::net::TcpStream::connect(address).expect("a connection");
            // More than the buffers of any system hold.
            let bytes = vec![7; 64 << 20];
            let mut idle = connect();
            let (stream, _) = listener.accept().await.expect("accepted");
            let mut connection = Connection::new(stream, Duration::from_millis(50));
            let failed = send(&mut connection, &bytes).await.expect_err("nobody reads");
            assert_eq!(failed.kind(), io::ErrorKind::TimedOut);
            drop(connection);
            let mut got = Vec::new();
            idle.read_to_end(&mut got).expect("what was sent before");
            assert!(got.len() < bytes.len() && got.iter().all(|&byte| byte == 7));

            let mut busy = connect();
            let reading = std::thread::spawn(move || {
                let mut got = Vec::new();
                busy.read_to_end(&mut got).map(|_| got)
            });
            let (stream, _) = listener.accept().await.expect("accepted");
            let mut connection = Connection::new(stream, Duration::from_secs(60));
            send(&mut connection, &bytes).await.expect("somebody reads");
            drop(connection);
            assert!(reading.join().expect("no panic").expect("all of it") == bytes);
        });
    }
}
