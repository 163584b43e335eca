//! The HTTP server: the page and its socket, on 127.0.0.1, below a secret path.
//!
//! Other pages of the browser cannot read a response of another origin, but can open sockets and can point a name of
//! their own at 127.0.0.1. So each request needs the secret, a `Host` that is this server, and no foreign `Origin`.

mod visitors;

use super::hub::Hub;
use super::{page, socket};
use crate::codes;
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{ConnectInfo, Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::io;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;
use tailor_mesh::error::{Error, ErrorKind};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::task::block_in_place;
use visitors::{Known, Visitors};

/// Largest message of a page. \[bytes\]
const LARGEST_REQUEST: usize = 1 << 20;
/// Time that reads and saves of pages have to end after the server.
const GRACE: Duration = Duration::from_millis(100);

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
    run_to_end(runtime, async {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await.map_err(|e| {
            Error::new(ErrorKind::Usage, format!("--port {port}"), format!("cannot be opened: {e}"))
                .code(codes::PREVIEW_SERVER)
                .remedy("choose another port, or 0 for any that is free")
                .caused_by(e)
        })?;
        let port = listener.local_addr().map_err(fault)?.port();
        let access = Arc::new(Access { secret: secret()?, port });
        ready(&format!("http://127.0.0.1:{port}/{}/", access.secret));
        let service = router(hub, &access).into_make_service_with_connect_info::<Known>();
        tokio::select! {
            ended = axum::serve(Visitors::new(listener), service) => ended.map_err(fault),
            () = interrupted() => Ok(()),
        }
    })
}

/// Runs `serving` to its end. Reads and saves that go on then are left behind: they may take long, and the program ends.
fn run_to_end<T>(runtime: Runtime, serving: impl Future<Output = T>) -> T {
    let result = runtime.block_on(serving);
    runtime.shutdown_timeout(GRACE);
    result
}

fn router(hub: &Arc<Hub>, access: &Arc<Access>) -> Router {
    let hub = Arc::clone(hub);
    let mut router = Router::new().route("/socket", get(upgrade)).route("/image/{number}", get(image)).with_state(hub);
    for file in &page::FILES {
        let path = if file.name == "index.html" { "/" } else { file.name };
        let respond = move || async move { ([(header::CONTENT_TYPE, file.media_type)], file.sent()) };
        router = router.route(&format!("/{}", path.trim_start_matches('/')), get(respond));
    }
    let router = router.layer(middleware::from_fn(know));
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

/// Answers with an image of the garment's materials.
async fn image(State(hub): State<Arc<Hub>>, Path(number): Path<usize>) -> Response {
    match block_in_place(|| hub.snapshot().stage.images.read(number)) {
        Some((media_type, content)) => ([(header::CONTENT_TYPE, media_type)], content).into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}

/// Refuses requests from elsewhere and adds the headers of every response.
async fn guard(State(access): State<Arc<Access>>, request: Request, next: Next) -> Response {
    let mut response =
        if access.allows(request.headers()) { next.run(request).await } else { StatusCode::FORBIDDEN.into_response() };
    response.headers_mut().extend(HEADERS.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response
}

/// Notes that the visitor of a request knows the secret.
async fn know(ConnectInfo(known): ConnectInfo<Known>, request: Request, next: Next) -> Response {
    known.set();
    next.run(request).await
}

/// 128 random bits as text.
fn secret() -> Result<String, Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| Error::internal(format!("no random numbers: {e}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpStream;
    use std::time::Instant;

    fn runtime() -> Runtime {
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("a runtime")
    }

    #[test]
    fn a_read_that_goes_on_does_not_delay_the_end() {
        let start = Instant::now();
        run_to_end(runtime(), async {
            let reads = || tokio::task::block_in_place(|| std::thread::sleep(Duration::from_secs(5)));
            tokio::spawn(async move { reads() });
            tokio::time::sleep(Duration::from_millis(50)).await;
        });
        assert!(start.elapsed() < Duration::from_millis(500), "{:?}", start.elapsed());
    }

    /// Whether the server has closed a connection within the time.
    fn is_closed(mut stream: &TcpStream, time: Duration) -> bool {
        stream.set_read_timeout(Some(time)).expect("a time");
        match stream.read(&mut [0]) {
            Ok(count) => count == 0,
            Err(e) => !matches!(e.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut),
        }
    }

    #[test]
    fn visitors_without_the_secret_are_few_and_do_not_stay() {
        let runtime = runtime();
        let listener = runtime.block_on(TcpListener::bind((Ipv4Addr::LOCALHOST, 0))).expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let access = Arc::new(Access { secret: "secret".into(), port });
        let page = Router::new().route("/", get(|| async { "the page" })).layer(middleware::from_fn(know));
        let guard = middleware::from_fn_with_state(access, guard);
        let router = Router::new().nest("/secret/", page).fallback(|| async { StatusCode::NOT_FOUND }).layer(guard);
        let service = router.into_make_service_with_connect_info::<Known>();
        runtime.spawn(async { axum::serve(Visitors::new(listener), service).await });

        let visitor = || TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("a connection");
        let ask = |mut stream: &TcpStream, path: &str| {
            let request = format!("GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n");
            stream.write_all(request.as_bytes()).expect("a request");
            let mut answer = [0; 2048];
            let count = stream.read(&mut answer).expect("an answer");
            String::from_utf8_lossy(&answer[..count]).into_owned()
        };
        let early = visitor();
        assert!(ask(&early, "/secret/").contains("the page"));
        let asked = visitor();
        assert!(ask(&asked, "/other/").contains("404"));
        let idle: Vec<TcpStream> = (0..300).map(|_| visitor()).collect();
        let page = visitor();
        assert!(ask(&page, "/secret/").contains("the page"), "it gets in");
        let open = idle.iter().filter(|stream| !is_closed(stream, Duration::from_millis(20))).count();
        assert!((1..=visitors::STRANGERS).contains(&open), "{open} of them are open");
        assert!(is_closed(&asked, Duration::from_secs(1)), "an answer of 404 is no way in");
        assert!(is_closed(&idle[299], visitors::PATIENCE + Duration::from_secs(5)), "they do not stay");
        assert!(ask(&early, "/secret/").contains("the page"), "a page stays");
        runtime.shutdown_timeout(GRACE);
    }
}
