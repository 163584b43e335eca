//! The HTTP server: the page and its socket, on 127.0.0.1, below a secret path.
//!
//! Other pages of the browser cannot read a response of another origin, but can open sockets and can point a name of
//! their own at 127.0.0.1. So each request needs the secret, a `Host` that is this server, and no foreign `Origin`.

use super::hub::Hub;
use super::{page, socket};
use crate::error::{Error, ErrorCode, ErrorKind};
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::serve::ListenerExt;
use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use tokio::net::{TcpListener, TcpStream};

/// Largest message of a page. \[bytes\]
const LARGEST_REQUEST: usize = 1 << 20;

/// Headers of every response. The page loads nothing from elsewhere, is in no frame, and leaks its address to nobody.
const HEADERS: [(HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; connect-src 'self' ws:; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; \
         frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Who may ask.
struct Access {
    secret: String,
    port: u16,
}

impl Access {
    /// The name of this server in `Host`, and after the scheme in `Origin`.
    fn is_own(&self, host: &str) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port))
    }

    fn allows(&self, headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
        let host = text(header::HOST).is_some_and(|host| self.is_own(host));
        let origin = match headers.get(header::ORIGIN) {
            Some(_) => text(header::ORIGIN).and_then(|o| o.strip_prefix("http://")).is_some_and(|o| self.is_own(o)),
            None => true,
        };
        host && origin
    }
}

/// Serves pages until the process is interrupted. `ready` gets the address.
///
/// # Errors
/// A port that is in use or not allowed.
pub fn run(hub: &Arc<Hub>, port: u16, ready: impl FnOnce(&str)) -> Result<(), Error> {
    let fault = |e: io::Error| Error::internal(format!("the server failed: {e}"));
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().map_err(fault)?;
    runtime.block_on(async {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await.map_err(|e| {
            Error::new(ErrorKind::Usage, format!("--port {port}"), format!("cannot be opened: {e}"))
                .code(ErrorCode::PreviewServer)
                .remedy("choose another port, or 0 for any that is free")
                .caused_by(e)
        })?;
        let port = listener.local_addr().map_err(fault)?.port();
        let access = Arc::new(Access { secret: secret()?, port });
        ready(&format!("http://127.0.0.1:{port}/{}/", access.secret));
        tokio::select! {
            ended = axum::serve(listener.tap_io(send_at_once), router(hub, &access)) => ended.map_err(fault),
            () = interrupted() => Ok(()),
        }
    })
}

fn router(hub: &Arc<Hub>, access: &Arc<Access>) -> Router {
    let mut router = Router::new().route("/socket", get(upgrade)).with_state(Arc::clone(hub));
    for file in &page::FILES {
        let path = if file.name == "index.html" { "/" } else { file.name };
        let respond = move || async move { ([(header::CONTENT_TYPE, file.media_type)], file.content) };
        router = router.route(&format!("/{}", path.trim_start_matches('/')), get(respond));
    }
    // Unlike `nest`, the folder's own path ends in a slash, to which the page's addresses are relative.
    let guard = middleware::from_fn_with_state(Arc::clone(access), guard);
    Router::new()
        .nest(&format!("/{}/", access.secret), router)
        .fallback(|| async { StatusCode::NOT_FOUND })
        .layer(guard)
}

async fn upgrade(State(hub): State<Arc<Hub>>, upgrade: WebSocketUpgrade) -> Response {
    upgrade.max_message_size(LARGEST_REQUEST).on_upgrade(move |socket| socket::run(socket, hub))
}

/// Refuses requests from elsewhere and adds the headers of every response.
async fn guard(State(access): State<Arc<Access>>, request: Request, next: Next) -> Response {
    let mut response =
        if access.allows(request.headers()) { next.run(request).await } else { StatusCode::FORBIDDEN.into_response() };
    response.headers_mut().extend(HEADERS.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response
}

/// 128 random bits as text.
fn secret() -> Result<String, Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| Error::internal(format!("no random numbers: {e}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// A mesh follows a small message, and would else wait until the browser has acknowledged that one.
fn send_at_once(stream: &mut TcpStream) {
    // Without it the page is slower.
    let _ = stream.set_nodelay(true);
}

/// Waits for Ctrl-C or a request to end.
async fn interrupted() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        if let Ok(mut end) = signal(SignalKind::terminate()) {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => {}
                _ = end.recv() => {}
            }
            return;
        }
    }
    let _ = tokio::signal::ctrl_c().await;
}
