//! Limits how many messages a client may send, with a token bucket.

/// Allowed messages per second on average, and the size of the bucket.
pub(super) const MESSAGES_PER_S: f64 = 200.0;

/// Number of messages beyond the limit after which the connection ends.
const PATIENCE: u32 = 600;

/// The decision about a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admission {
    /// Handle it.
    Handle,
    /// Drop it and warn the client: it is the first message beyond the limit.
    Warn,
    /// Drop it.
    Drop,
    /// End the connection.
    Close,
}

/// The bucket of one client.
#[derive(Clone, Copy, Debug)]
pub(super) struct TokenBucket {
    tokens: f64,
    last_s: f64,
    excess: u32,
}

impl TokenBucket {
    /// A full bucket at `now_s`.
    pub(super) fn new(now_s: f64) -> Self {
        Self { tokens: MESSAGES_PER_S, last_s: now_s, excess: 0 }
    }

    /// Decides about a message that arrives at `now_s`, s on a clock that never runs backwards.
    pub(super) fn admit(&mut self, now_s: f64) -> Admission {
        self.tokens =
            (self.tokens + (now_s - self.last_s).max(0.0) * MESSAGES_PER_S).min(MESSAGES_PER_S);
        self.last_s = now_s;
        if self.tokens >= MESSAGES_PER_S / 2.0 {
            self.excess = 0;
        }
        if self.tokens >= 1.0 {
            self.tokens -= 1.0;
            return Admission::Handle;
        }
        self.excess += 1;
        match self.excess {
            1 => Admission::Warn,
            n if n > PATIENCE => Admission::Close,
            _ => Admission::Drop,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_150_per_second_is_never_refused() {
        let mut bucket = TokenBucket::new(0.0);
        assert!((1..3000).all(|n| bucket.admit(f64::from(n) / 150.0) == Admission::Handle));
    }

    #[test]
    fn a_flood_is_warned_once_then_dropped_then_closed() {
        let mut bucket = TokenBucket::new(0.0);
        let answers: Vec<Admission> = (0..900).map(|_| bucket.admit(0.0)).collect();
        let count = |wanted| answers.iter().filter(|answer| **answer == wanted).count();
        assert_eq!(count(Admission::Handle), MESSAGES_PER_S as usize);
        assert_eq!(count(Admission::Warn), 1);
        assert_eq!(answers[200 + PATIENCE as usize], Admission::Close);
        assert_eq!(count(Admission::Drop), PATIENCE as usize - 1);
    }

    #[test]
    fn a_second_of_silence_forgives() {
        let mut bucket = TokenBucket::new(0.0);
        (0..500).for_each(|_| {
            bucket.admit(0.0);
        });
        assert_eq!(bucket.admit(1.0), Admission::Handle);
        assert_eq!(bucket.excess, 0);
    }
}
