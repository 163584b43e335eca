//! The connections of the server. Those that have not shown the secret are few and do not stay, so that they cannot keep the page
//! out.

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot::{self, Receiver, Sender};
use tokio::time::{Sleep, sleep};

/// Most connections that have not shown the secret. The oldest one ends where another comes.
pub const STRANGERS: usize = 32;
/// Time to show the secret.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// Whether a connection has shown the secret.
#[derive(Clone, Default)]
pub struct Known(Arc<AtomicBool>);

impl Known {
    /// Notes that it has.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Connected<IncomingStream<'_, Visitors>> for Known {
    fn connect_info(stream: IncomingStream<'_, Visitors>) -> Self {
        stream.io().known.clone()
    }
}

/// Accepts connections.
pub struct Visitors {
    listener: TcpListener,
    /// The connections that have not shown the secret, oldest first. One ends when its sender is dropped.
    strangers: VecDeque<(Known, Sender<()>)>,
}

impl Visitors {
    /// Accepts the connections of a listener.
    pub fn new(listener: TcpListener) -> Self {
        Self { listener, strangers: VecDeque::new() }
    }
}

impl Listener for Visitors {
    type Io = Visitor;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Visitor, SocketAddr) {
        let (stream, address) = Listener::accept(&mut self.listener).await;
        // A mesh follows a small message, and would else wait until the browser has acknowledged that one. Without it the page
        // is slower.
        let _ = stream.set_nodelay(true);
        self.strangers.retain(|(known, stay)| !known.is_set() && !stay.is_closed());
        if self.strangers.len() >= STRANGERS {
            self.strangers.pop_front();
        }
        let (known, (stay, ended)) = (Known::default(), oneshot::channel());
        self.strangers.push_back((known.clone(), stay));
        (Visitor { stream, known, ended, patience: Box::pin(sleep(PATIENCE)), is_ended: false }, address)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection.
pub struct Visitor {
    stream: TcpStream,
    known: Known,
    /// Ready when another one takes its place.
    ended: Receiver<()>,
    patience: Pin<Box<Sleep>>,
    is_ended: bool,
}

impl AsyncRead for Visitor {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, out: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        // A connection is read from while it waits for a request.
        if !self.known.is_set() {
            self.is_ended = self.is_ended
                || Pin::new(&mut self.ended).poll(context).is_ready()
                || self.patience.as_mut().poll(context).is_ready();
            if self.is_ended {
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
        }
        Pin::new(&mut self.stream).poll_read(context, out)
    }
}

impl AsyncWrite for Visitor {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}
