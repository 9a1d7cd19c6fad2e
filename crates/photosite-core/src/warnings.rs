//! Things worth telling the user once.

use crate::shorten::shorten;

/// Messages in the order in which they first came up, each once.
#[derive(Debug, Default)]
pub struct Warnings {
    messages: Vec<String>,
}

impl Warnings {
    /// Adds a message unless it is there already.
    pub fn once(&mut self, message: impl Into<String>) {
        let message = shorten(message.into());
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
    }

    /// The messages, each headed by the file they are about.
    pub fn of_file(self, path: &std::path::Path) -> Vec<String> {
        self.messages.into_iter().map(|message| format!("{}: {message}", path.display())).collect()
    }

    /// The messages alone.
    pub fn into_messages(self) -> Vec<String> {
        self.messages
    }
}
