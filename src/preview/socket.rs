//! The connection of one page: its requests, and what it has been sent.

use super::frame::{Sent, frame};
use super::hub::{Hub, Snapshot};
use super::messages::{FaultsMessage, Origin, PageMessage, Role, ServerMessage, StateMessage, View};
use super::save::{self, presets};
use super::select::select;
use super::stage::Stage;
use axum::extract::ws::{self, WebSocket};
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor_mesh::error::Fault;
use tailor_usd::Selection;
use tokio::task::block_in_place;

/// Serves a page until it goes.
pub async fn run(mut socket: WebSocket, hub: Arc<Hub>) {
    let mut client = Client::default();
    client.serve(&mut socket, &hub).await;
    if client.comparing {
        // Nobody is left to end it.
        hub.edit(|document| document.comparing = None);
    }
}

fn text(text: impl Into<ws::Utf8Bytes>) -> ws::Message {
    ws::Message::Text(text.into())
}

/// The requests of a page and the meshes that it has.
#[derive(Default)]
struct Client {
    serial: u64,
    view: View,
    comparing: bool,
    stage: Option<Arc<Stage>>,
    state: Option<(Arc<StateMessage>, u64)>,
    faults: BTreeMap<Origin, Vec<Fault>>,
    meshes: BTreeMap<Role, Option<Sent>>,
    products: BTreeMap<Role, Arc<str>>,
    messages: BTreeMap<String, Arc<str>>,
}

impl Client {
    async fn serve(&mut self, socket: &mut WebSocket, hub: &Arc<Hub>) {
        let mut changes = hub.subscribe();
        loop {
            let answers = tokio::select! {
                message = socket.recv() => match message {
                    Some(Ok(ws::Message::Text(text))) => block_in_place(|| self.request(&text, hub)),
                    Some(Ok(_)) => Vec::new(),
                    Some(Err(_)) | None => return,
                },
                change = changes.changed() => match change {
                    Ok(()) => Vec::new(),
                    Err(_) => return,
                },
            };
            changes.mark_unchanged();
            let news = block_in_place(|| self.news(&hub.snapshot()));
            for message in answers.into_iter().chain(news) {
                if socket.send(message).await.is_err() {
                    return;
                }
            }
        }
    }

    /// Does what a page asks for.
    fn request(&mut self, message: &str, hub: &Arc<Hub>) -> Vec<ws::Message> {
        // A page of this program sends nothing else.
        let Ok(request) = serde_json::from_str::<PageMessage>(message) else { return Vec::new() };
        match request {
            PageMessage::Edit { serial, gesture, edits } => {
                self.serial = serial;
                hub.replace(edits, gesture);
            }
            PageMessage::Kept { time, restore } => hub.answer(time, restore),
            PageMessage::Undo => hub.edit(|document| document.undo()),
            PageMessage::Redo => hub.edit(|document| document.redo()),
            PageMessage::Compare { with } => {
                self.comparing = with.is_some();
                hub.edit(|document| document.comparing = with);
            }
            PageMessage::Variant { prim, set, choice } => hub.select(Selection { prim, set, choice }),
            PageMessage::Select { selection, change, set } => {
                let selected = select(&hub.snapshot(), &selection, change, &set);
                return vec![text(ServerMessage::Selection(selected).to_text())];
            }
            PageMessage::View(view) => {
                self.meshes.retain(|role, _| view.roles.contains(role));
                self.view = view;
            }
            PageMessage::Level { level } => hub.show_level(level),
            PageMessage::Fit { share } => hub.show_on_way(share),
            PageMessage::Bodies => hub.find_bodies(),
            PageMessage::Pose { frame } => hub.pose(frame),
            PageMessage::Build { path, overwrite } => hub.start_build(&path, overwrite),
            PageMessage::Reload => {
                hub.reload();
                presets::read(hub);
            }
            PageMessage::Plan { path } => return vec![text(ServerMessage::Save(save::plan(hub, &path)).to_text())],
            PageMessage::Save { path, overwrite } => {
                return vec![text(ServerMessage::Save(save::save(hub, &path, overwrite)).to_text())];
            }
            PageMessage::Preset { kind, name, values } => {
                let saved = presets::save(hub, &kind, &name, values.as_ref());
                return vec![text(ServerMessage::PresetSaved(saved).to_text())];
            }
        }
        Vec::new()
    }

    /// The changes since the last time.
    fn news(&mut self, now: &Snapshot) -> Vec<ws::Message> {
        let mut news = Vec::new();
        if !self.stage.as_ref().is_some_and(|stage| Arc::ptr_eq(stage, &now.stage)) {
            self.stage = Some(Arc::clone(&now.stage));
            self.state = None;
            self.messages.remove("fit");
            news.push(text(now.stage.message.clone()));
        }
        let (state, serial) = (&now.state, self.serial);
        let is_known = |known: &(Arc<StateMessage>, u64)| Arc::ptr_eq(&known.0, state) && known.1 == serial;
        if !self.state.as_ref().is_some_and(is_known) {
            self.state = Some((Arc::clone(state), serial));
            let message = StateMessage { serial, ..StateMessage::clone(state) };
            news.push(text(ServerMessage::State(message).to_text()));
        }
        for (&origin, faults) in now.faults.iter() {
            if self.faults.get(&origin).map_or(&[][..], Vec::as_slice) != faults {
                self.faults.insert(origin, faults.clone());
                news.push(text(ServerMessage::Faults(FaultsMessage { origin, faults }).to_text()));
            }
        }
        self.meshes(now, &mut news);
        for (&role, shown) in &now.shown {
            let Some(message) = shown.message.get() else { continue };
            if !self.products.get(&role).is_some_and(|sent| Arc::ptr_eq(sent, message)) {
                self.products.insert(role, Arc::clone(message));
                news.push(text(&**message));
            }
        }
        for (kind, message) in &now.messages {
            if self.messages.get(kind) != Some(message) {
                self.messages.insert(kind.clone(), Arc::clone(message));
                news.push(text(&**message));
            }
        }
        news
    }

    fn meshes(&mut self, now: &Snapshot, news: &mut Vec<ws::Message>) {
        self.meshes.retain(|role, _| now.shown.contains_key(role));
        for (&role, shown) in now.shown.iter().filter(|(role, _)| self.view.roles.contains(role)) {
            let shown = now.posed.get(&role).or(now.on_way.get(&role)).unwrap_or(shown);
            match frame(role, shown, &self.view, self.meshes.entry(role).or_default()) {
                Ok(Some(bytes)) => news.push(ws::Message::Binary(bytes.into())),
                Ok(None) => {}
                Err(error) => {
                    let origin = if role == Role::Sim { Origin::Sim } else { Origin::Render };
                    news.push(text(ServerMessage::Faults(FaultsMessage { origin, faults: &error.faults }).to_text()));
                }
            }
        }
    }
}
