//! Cards that this process has open: whoever asks for one again gets it with the kernels that it has compiled.

use std::sync::{Arc, Mutex};

use crate::adapters::{Card, open};

/// Open cards of a process, by the numbers that they were asked for with.
type OpenCards = Vec<(Option<usize>, Arc<Card>)>;

/// Open cards, and the process that has opened them. Nobody waits for them: in a forked child they may be locked for
/// ever, by a thread of its parent.
static OPEN: Mutex<Option<(u32, OpenCards)>> = Mutex::new(None);

/// Card of that number, or the first that is no software, opened for this process unless it is open and works. `None`
/// where there is none.
///
/// # Errors
///
/// Words on why it cannot be used.
pub fn shared(number: Option<usize>) -> Result<Option<Arc<Card>>, String> {
    if let Some(card) = kept(number) {
        return Ok(Some(card));
    }
    let card = open(number)?.map(Arc::new);
    if let Some(card) = &card {
        keep(number, card);
    }
    Ok(card)
}

/// Card of that number that this process has open, if its driver has found no fault.
fn kept(number: Option<usize>) -> Option<Arc<Card>> {
    let mut open = OPEN.try_lock().ok()?;
    if let Some((_, of_parent)) = open.take_if(|(owner, _)| *owner != std::process::id()) {
        // Closing them would wait for threads of drivers that are not in this process.
        std::mem::forget(of_parent);
    }
    let (_, cards) = open.as_mut()?;
    cards.retain(|(_, card)| card.works());
    cards.iter().find(|(asked, _)| *asked == number).map(|(_, card)| Arc::clone(card))
}

fn keep(number: Option<usize>, card: &Arc<Card>) {
    let Ok(mut open) = OPEN.try_lock() else { return };
    let (owner, cards) = open.get_or_insert_with(|| (std::process::id(), Vec::new()));
    if *owner == std::process::id() {
        cards.push((number, Arc::clone(card)));
    }
}
