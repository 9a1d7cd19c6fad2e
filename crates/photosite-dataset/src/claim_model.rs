//! Model of how processes claim, make and publish one image, explored in every order of their steps.
//!
//! A process goes through [`Step`]s, each of which is one system call in [`Lock::take`](photosite_files::lock::Lock),
//! [`DatasetFolder::begin`](super::folder::DatasetFolder),
//! [`UnfinishedFolder`](photosite_files::unfinished::UnfinishedFolder) or `DatasetFolder::sweep`. Between any two steps
//! every other process may take one, or this one may die: the kernel then releases its lock, and its files stay. All
//! states that can be reached in this way are explored. Other tests run the code with real processes; this model shows
//! that no order of the steps loses an image or publishes an incomplete one.

use std::collections::{BTreeSet, HashMap, VecDeque};

/// Next step of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Step {
    /// Check whether the image is there and complete.
    CheckDepth,
    /// Open the lock's file, which is made where there is none.
    OpenLock,
    /// Ask the kernel for the lock.
    TakeLock,
    /// Check whether the locked file still has the name.
    CheckName,
    /// Check once more whether the image is there.
    LookAgain,
    /// Take the image's number away from a damaged one.
    MoveDamaged,
    /// List what dead processes have left, where the lock proves that they are dead.
    ListLeftovers,
    /// Make a folder of its own.
    Begin,
    /// Remove a leftover folder.
    RemoveLeftover,
    /// Write the files; some of them are there in between.
    WriteSome,
    WriteRest,
    /// Check whether all files are there.
    Check,
    /// Rename the folder, which replaces an empty one only.
    Publish,
    /// Remove its own folder, where another process's was first.
    Drop,
    /// Remove the lock's file.
    RemoveLock,
    /// Close the lock's file, which releases the lock.
    CloseLock,
    /// End: the process has seen the image, and swept under the same lock what dead processes had left.
    Done,
    /// End: the process reported that the image is damaged and that nobody may remove it here.
    Refused,
    /// End: the process reported that its files were taken from it.
    Failed,
    Dead,
}

/// Folder of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Files {
    None,
    Some,
    All,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Process {
    step: Step,
    /// Lock's file that the process has open, by its inode, and whether it holds the lock.
    open: Option<u8>,
    is_locked: bool,
    /// Leftovers of dead processes at the time of the check.
    leftovers: BTreeSet<u8>,
    /// Whether the process has the image and only sweeps.
    sweeps: bool,
}

/// State of the disk and of the processes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    processes: Vec<Process>,
    /// Inode that has the lock's name.
    lock_name: Option<u8>,
    /// Files under the image's number; `None` where there is no folder.
    image: Option<Files>,
    /// Folders under names of their own, by the process that made them.
    partial: Vec<Option<Files>>,
}

/// Assumptions about the machine.
#[derive(Clone, Copy, Debug)]
struct World {
    processes: u8,
    knows_locks: bool,
    /// Files under the image's number at first.
    at_first: Option<Files>,
    /// Number of processes that may die.
    deaths: usize,
}

impl World {
    fn begin(self) -> State {
        let process =
            Process { step: Step::CheckDepth, open: None, is_locked: false, leftovers: BTreeSet::new(), sweeps: false };
        State {
            processes: vec![process; usize::from(self.processes)],
            lock_name: None,
            image: self.at_first,
            partial: vec![None; usize::from(self.processes)],
        }
    }

    /// State after one step of process `i`; `None` where it is at its end.
    fn after(self, state: &State, i: usize) -> Option<State> {
        let mut next = state.clone();
        let is_whole = state.image == Some(Files::All);
        let p = &mut next.processes[i];
        match p.step {
            Step::CheckDepth if is_whole && !p.sweeps => (p.sweeps, p.step) = (true, Step::OpenLock),
            Step::CheckDepth => p.step = Step::OpenLock,
            Step::OpenLock => {
                // An inode that nobody has open and no name leads to is free again.
                let used: BTreeSet<u8> = state.processes.iter().filter_map(|p| p.open).chain(state.lock_name).collect();
                let free = (0..).find(|inode| !used.contains(inode));
                let inode = state.lock_name.or(free)?;
                (p.open, p.step) = (Some(inode), Step::TakeLock);
                next.lock_name = Some(inode);
            }
            Step::TakeLock => {
                let is_taken = self.knows_locks
                    && state.processes.iter().enumerate().any(|(j, o)| j != i && o.is_locked && o.open == p.open);
                if is_taken {
                    // Theirs: looked at again later. Who only sweeps leaves it to them.
                    (p.open, p.step) = (None, if p.sweeps { Step::Done } else { Step::CheckDepth });
                } else {
                    (p.is_locked, p.step) = (self.knows_locks, Step::CheckName);
                }
            }
            Step::CheckName if self.knows_locks && state.lock_name != p.open => {
                (p.open, p.is_locked, p.step) = (None, false, Step::OpenLock);
            }
            Step::CheckName => p.step = Step::LookAgain,
            Step::LookAgain if p.sweeps && is_whole => p.step = Step::ListLeftovers,
            Step::LookAgain if is_whole || p.sweeps => p.step = Step::RemoveLock,
            Step::LookAgain => p.step = Step::MoveDamaged,
            // Without locks another process may be about to put a whole one in its place.
            Step::MoveDamaged if state.image == Some(Files::Some) && !p.is_locked => p.step = Step::Refused,
            Step::MoveDamaged => {
                next.image = state.image.filter(|files| *files == Files::All);
                p.step = Step::ListLeftovers;
            }
            Step::ListLeftovers => {
                // Those of processes that live without a lock are not known from others.
                let left = (0..self.processes).filter(|&j| state.partial[usize::from(j)].is_some());
                p.leftovers = if p.is_locked { left.collect() } else { BTreeSet::new() };
                p.step = if p.sweeps { Step::RemoveLeftover } else { Step::Begin };
            }
            Step::Begin => {
                p.step = Step::RemoveLeftover;
                next.partial[i] = Some(Files::None);
            }
            Step::RemoveLeftover => match p.leftovers.pop_first() {
                Some(left) => next.partial[usize::from(left)] = None,
                None if p.sweeps => p.step = Step::RemoveLock,
                None => p.step = Step::WriteSome,
            },
            Step::WriteSome | Step::WriteRest | Step::Check if state.partial[i].is_none() => p.step = Step::Failed,
            Step::WriteSome => {
                p.step = Step::WriteRest;
                next.partial[i] = Some(Files::Some);
            }
            Step::WriteRest => {
                p.step = Step::Check;
                next.partial[i] = Some(Files::All);
            }
            Step::Check => p.step = Step::Publish,
            Step::Publish if state.partial[i].is_none() => p.step = Step::Failed,
            Step::Publish if state.image.is_some() => p.step = Step::Drop,
            Step::Publish => {
                next.image = next.partial[i].take();
                p.step = Step::RemoveLock;
            }
            Step::Drop => {
                p.step = Step::RemoveLock;
                next.partial[i] = None;
            }
            Step::RemoveLock => {
                p.step = Step::CloseLock;
                next.lock_name = None;
            }
            Step::CloseLock => {
                (p.open, p.is_locked) = (None, false);
                p.step = if p.sweeps { Step::Done } else { Step::CheckDepth };
            }
            Step::Done | Step::Refused | Step::Failed | Step::Dead => return None,
        }
        Some(next)
    }

    /// State after process `i` is killed.
    fn killed(self, state: &State, i: usize) -> Option<State> {
        let dead = state.processes.iter().filter(|p| p.step == Step::Dead).count();
        if dead == self.deaths || self.after(state, i).is_none() {
            return None;
        }
        let mut next = state.clone();
        let p = &mut next.processes[i];
        (p.step, p.open, p.is_locked) = (Step::Dead, None, false);
        p.sweeps = false;
        p.leftovers.clear();
        Some(next)
    }

    /// All reachable states, each with its successors; the first is the initial state.
    fn explore(self, check: impl Fn(&State, &State)) -> Vec<(State, Vec<usize>)> {
        let mut known = HashMap::from([(self.begin(), 0)]);
        let mut states = vec![(self.begin(), Vec::new())];
        let mut todo = VecDeque::from([0]);
        while let Some(at) = todo.pop_front() {
            let state = states[at].0.clone();
            let steps = (0..state.processes.len())
                .flat_map(|i| [self.after(&state, i), self.killed(&state, i)])
                .flatten()
                .collect::<Vec<_>>();
            for next in steps {
                check(&state, &next);
                let index = *known.entry(next.clone()).or_insert_with(|| {
                    states.push((next, Vec::new()));
                    todo.push_back(states.len() - 1);
                    states.len() - 1
                });
                states[at].1.push(index);
            }
        }
        states
    }
}

/// Whether a process is between knowing that the lock is its own and taking the lock's name away.
fn has_turn(process: &Process) -> bool {
    process.is_locked && !matches!(process.step, Step::TakeLock | Step::CheckName | Step::CloseLock)
}

/// Asserts that no published image is ever incomplete, and that a published one stays.
fn check_published(before: &State, after: &State) {
    assert_ne!(after.image, Some(Files::None), "{after:?}");
    let newly = after.image != before.image && after.image.is_some();
    assert!(!newly || after.image == Some(Files::All), "half an image: {after:?}");
}

/// Asserts that in every final state all living processes have the image, and that a final state can always be reached.
fn check_ends(states: &[(State, Vec<usize>)], is_tidy: bool) {
    let is_end = |(state, next): &(State, Vec<usize>)| {
        let is_over = |p: &Process| matches!(p.step, Step::Done | Step::Refused | Step::Failed | Step::Dead);
        next.is_empty() || state.processes.iter().all(is_over)
    };
    let mut ends_well = vec![false; states.len()];
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); states.len()];
    for (index, entry) in states.iter().enumerate() {
        entry.1.iter().for_each(|&next| before[next].push(index));
        if !is_end(entry) {
            continue;
        }
        let state = &entry.0;
        let is_alive = state.processes.iter().any(|p| p.step == Step::Done);
        assert!(!is_alive || state.image == Some(Files::All), "lost: {state:?}");
        let left = state.partial.iter().flatten().count();
        assert!(!is_tidy || !is_alive || left == 0, "left behind: {state:?}");
        ends_well[index] = true;
    }
    let mut todo: Vec<usize> = (0..states.len()).filter(|&i| ends_well[i]).collect();
    while let Some(at) = todo.pop() {
        for &earlier in &before[at] {
            if !std::mem::replace(&mut ends_well[earlier], true) {
                todo.push(earlier);
            }
        }
    }
    assert!(ends_well.iter().all(|&ends| ends), "somebody waits forever");
}

/// Initial states: no image, an image that lost a file, a complete one.
const AT_FIRST: [Option<Files>; 3] = [None, Some(Files::Some), Some(Files::All)];

#[test]
fn with_locks_one_at_a_time_makes_the_image_and_leaves_nothing() {
    for at_first in AT_FIRST {
        for (processes, deaths) in [(1, 1), (2, 2), (3, 0), (3, 2)] {
            let world = World { processes, knows_locks: true, at_first, deaths };
            let states = world.explore(|before, after| {
                check_published(before, after);
                assert!(after.processes.iter().filter(|p| has_turn(p)).count() <= 1, "two have a turn: {after:?}");
                assert!(after.processes.iter().all(|p| p.step != Step::Failed), "robbed: {after:?}");
                let is_lost = before.image == Some(Files::All) && after.image.is_none();
                assert!(!is_lost, "a whole image is taken away: {before:?}");
            });
            // Somebody must be left who sweeps: a process that dies last leaves what the next one sweeps.
            check_ends(&states, deaths == 0);
            assert!(deaths < 2 || processes < 3 || states.len() > 1_000, "{}", states.len());
        }
    }
}

/// Test: each process makes the image if it must; the first to finish publishes it.
#[test]
fn without_locks_no_half_image_is_published_and_none_is_lost() {
    for at_first in AT_FIRST {
        for (processes, deaths) in [(1, 1), (2, 2), (3, 1)] {
            let world = World { processes, knows_locks: false, at_first, deaths };
            let states = world.explore(|before, after| {
                check_published(before, after);
                assert!(after.processes.iter().all(|p| p.step != Step::Failed), "robbed: {after:?}");
            });
            check_ends(&states, false);
        }
    }
}

/// Test that the model can fail: rules that the code must keep are broken one by one.
#[test]
fn a_lock_whose_name_is_not_looked_at_lets_two_have_a_turn() {
    let world = World { processes: 3, knows_locks: true, at_first: None, deaths: 0 };
    let two_have_it = |state: &State| state.processes.iter().filter(|p| has_turn(p)).count() > 1;
    let mut todo = VecDeque::from([world.begin()]);
    let mut known: BTreeSet<String> = BTreeSet::new();
    let mut is_found = false;
    while let Some(state) = todo.pop_front() {
        is_found |= two_have_it(&state);
        for i in 0..3 {
            let mut state = state.clone();
            // The check that Lock::take makes is left out.
            if state.processes[i].step == Step::CheckName {
                state.processes[i].step = Step::LookAgain;
            }
            if let Some(next) = world.after(&state, i).filter(|next| known.insert(format!("{next:?}"))) {
                todo.push_back(next);
            }
        }
        if is_found {
            break;
        }
    }
    assert!(is_found);
}
