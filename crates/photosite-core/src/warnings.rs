//! Warnings that the user sees once.

use crate::shorten::shorten;

/// Distinct messages in the order in which they first came up.
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

    /// Messages, each headed by the file that it is about.
    pub fn of_file(self, path: &std::path::Path) -> Vec<String> {
        self.messages.into_iter().map(|message| format!("{}: {message}", path.display())).collect()
    }

    /// Messages alone.
    pub fn into_messages(self) -> Vec<String> {
        self.messages
    }
}
