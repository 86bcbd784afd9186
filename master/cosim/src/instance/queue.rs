//! Queues between the master and a worker thread, which allocate nothing once they are made, not even
//! where a thread first sleeps, as those of `std` do.

use std::cell::Cell;
use std::hint::spin_loop;
use std::sync::mpsc::{self, SyncSender, TryRecvError, sync_channel};
use std::thread::{self, Thread};

/// Most and fewest times that an empty queue is polled before the thread sleeps: the most take some
/// 0.5 ms, as long as one thread may wait while another passes the values of many components. The
/// number falls while polling is in vain, as on a busy machine.
pub const SPINS: [usize; 2] = [20000, 20];

/// The end of a thread that sends; the other one is woken where this one is dropped too.
pub struct Sender<T> {
    queue: SyncSender<T>,
    // Dropped behind the queue, so that the other end finds it closed.
    other: Woken,
}

/// A thread that is woken where this is dropped.
struct Woken(Thread);

impl Drop for Woken {
    fn drop(&mut self) {
        self.0.unpark();
    }
}

impl<T> Sender<T> {
    /// Sends to `receiver`, the thread that has the other end of `queue`.
    pub fn new(queue: SyncSender<T>, receiver: Thread) -> Self {
        Self {
            queue,
            other: Woken(receiver),
        }
    }

    /// Sends an item; waits while the queue is full. If the other end is gone, nothing is sent.
    pub fn send(&self, item: T) {
        let _ = self.queue.send(item);
        self.other.0.unpark();
    }
}

/// The end of the thread that receives.
pub struct Receiver<T>(mpsc::Receiver<T>);

impl<T> Receiver<T> {
    /// The end of a queue for `size` items, and what a [`Sender`] is made of.
    pub fn new(size: usize) -> (SyncSender<T>, Self) {
        let (sender, receiver) = sync_channel(size);
        (sender, Self(receiver))
    }

    /// Takes the next item; None once the other end is gone. An empty queue is polled up to `spins`
    /// times.
    pub fn next(&self, spins: &Cell<usize>) -> Option<T> {
        let present = spins.get();
        for _ in 0..present {
            match self.0.try_recv() {
                Ok(found) => {
                    spins.set((present + present / 4 + 1).min(SPINS[0]));
                    return Some(found);
                }
                Err(TryRecvError::Empty) => spin_loop(),
                Err(TryRecvError::Disconnected) => return None,
            }
        }
        if present > 0 {
            spins.set((present - present / 4).max(SPINS[1]));
        }
        loop {
            match self.0.try_recv() {
                Ok(found) => return Some(found),
                Err(TryRecvError::Empty) => thread::park(),
                Err(TryRecvError::Disconnected) => return None,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use allocation_counter::measure;

    use super::*;

    #[test]
    fn a_sleeping_thread_is_woken_and_allocates_nothing() {
        let (sender, receiver) = Receiver::new(2);
        let sender = Sender::new(sender, thread::current());
        let other = thread::spawn(move || {
            for item in 0..3 {
                thread::sleep(Duration::from_millis(20));
                sender.send(item);
            }
            thread::sleep(Duration::from_millis(20));
        });
        let (mut taken, asleep) = (Vec::with_capacity(3), Cell::new(0));
        let counted = measure(|| taken.extend(std::iter::from_fn(|| receiver.next(&asleep))));
        assert_eq!((taken, counted.count_total), (vec![0, 1, 2], 0));
        other.join().unwrap();
    }
}
