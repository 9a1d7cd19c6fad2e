//! Places for connections: where none is left, the one that has said nothing for longest gives way to a new one.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};

use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

/// Guest at a place: a stranger until it has shown the token.
#[derive(Default)]
pub(super) struct Guest {
    is_known: AtomicBool,
    gives_way: Notify,
}

impl Guest {
    /// Marks a guest that has shown the token, and gives way to nobody.
    pub(super) fn is_known(&self) {
        self.is_known.store(true, Ordering::Relaxed);
    }

    /// Waits until the guest has to give way.
    pub(super) async fn gives_way(&self) {
        self.gives_way.notified().await;
    }
}

/// Places for connections, and the strangers that take some of them.
pub(super) struct Guests {
    places: Arc<Semaphore>,
    /// Guests that may still be strangers, the first that came first.
    strangers: VecDeque<Weak<Guest>>,
}

impl Guests {
    /// Guests with places for `places` connections at the same time.
    pub(super) fn new(places: usize) -> Self {
        Self { places: Arc::new(Semaphore::new(places)), strangers: VecDeque::new() }
    }

    /// A place for a new connection, once there is one.
    pub(super) async fn admit(&mut self) -> (Option<OwnedSemaphorePermit>, Arc<Guest>) {
        let is_stranger = |guest: &Guest| !guest.is_known.load(Ordering::Relaxed);
        self.strangers.retain(|guest| guest.upgrade().is_some_and(|guest| is_stranger(&guest)));
        if self.places.available_permits() == 0
            && let Some(oldest) = self.strangers.pop_front().and_then(|guest| guest.upgrade())
        {
            oldest.gives_way.notify_one();
        }
        // The semaphore is never closed.
        let place = Arc::clone(&self.places).acquire_owned().await.ok();
        let guest = Arc::new(Guest::default());
        self.strangers.push_back(Arc::downgrade(&guest));
        (place, guest)
    }
}

#[cfg(test)]
mod tests {
    use std::future::Future;
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use super::*;

    fn is_ready(future: impl Future) -> bool {
        matches!(pin!(future).poll(&mut Context::from_waker(Waker::noop())), Poll::Ready(_))
    }

    #[test]
    fn the_oldest_stranger_gives_way_and_who_is_known_does_not() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
        runtime.block_on(async {
            let mut guests = Guests::new(3);
            let mut inside = Vec::new();
            for _ in 0..3 {
                inside.push(guests.admit().await);
            }
            inside[0].1.is_known();
            assert!(!is_ready(guests.admit()), "all places are taken until somebody has left");
            let told: Vec<bool> = inside.iter().map(|(_, guest)| is_ready(guest.gives_way())).collect();
            assert_eq!(told, [false, true, false]);
            drop(inside.remove(1));
            assert!(is_ready(guests.admit()));
        });
    }
}
