//! Signals that end the command: what it was writing is removed first.

/// Removes temporary files when a signal ends the command, with the exit code 128 and the number of the signal. Signals that
/// are ignored, as by `nohup`, stay so. `serves` leaves the signals by which people end the preview to it.
///
/// # Errors
/// A system without another thread.
#[cfg(unix)]
pub fn tidy_up(serves: bool) -> std::io::Result<()> {
    use signal_hook::consts::{SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;

    // Terminals and people send the first ones, batch systems the others before they end a job.
    let all = [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGALRM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ];
    let is_left = |signal: i32| serves && [SIGINT, SIGTERM].contains(&signal);
    let mut signals = Signals::new(all.into_iter().filter(|signal| !is_left(*signal) && !is_ignored(*signal)))?;
    let wait = move || {
        // A file that may not grow is reported where it is written.
        if let Some(signal) = signals.forever().find(|signal| *signal != SIGXFSZ) {
            tailor_usd::remove_unfinished();
            std::process::exit(128 + signal);
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map(drop)
}

/// Signals end the command at once where there are none to wait for.
#[cfg(not(unix))]
pub fn tidy_up(_serves: bool) -> std::io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::uninit();
    // SAFETY: without a new action, the call only writes the present one, and has written it if it returns 0.
    unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) == 0
            && action.assume_init().sa_sigaction == libc::SIG_IGN
    }
}
