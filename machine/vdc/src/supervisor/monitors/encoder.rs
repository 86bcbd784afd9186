//! For how long an encoder stands while its joint is to move, for the monitors.

use super::lag::share;
use hdrm::DOF;
use serde::{Deserialize, Serialize};

/// Time over which motion that no encoder shows is integrated, s.
pub(super) const FORGETS: f64 = 0.25;
/// A joint sticks no more than it has shown: the multiple of the longest time, and of the most motion, for
/// which its encoder has shown the same count, and the least of both, s and rad; readings may be lost for
/// 50 ms. The first joint of the wrist stands where it turns back, and the last, where it hardly moves,
/// sticks at turns that it has not made before. It has shown it when it has been watched for a time, s,
/// before it stands, and for a multiple of that longest time.
pub(super) const LONGER: f64 = 3.0;
const STANDS: f64 = 0.06;
pub(super) const UNMOVED: [f64; DOF] = [0.003, 0.003, 0.003, 0.012, 0.003, 0.03];
pub(super) const SHOWN: [f64; 2] = [1.0, 100.0];
/// Part of that least motion below which a stand shows that a joint rests, not how it sticks; and the multiple
/// of that motion for which only the other stands count, each as if it were as much shorter.
const RESTS: f64 = 0.1;
const CERTAIN: f64 = 2.0;

/// For how long an encoder has shown the same count.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Encoder {
    /// The last reading, rad.
    pub(super) angle: f64,
    /// Time for which it has stood, s, and motion of its joint that was wanted meanwhile, with the
    /// forgetting time, rad: now, and at most before.
    pub(super) stands: [f64; 2],
    pub(super) most: [f64; 2],
    /// The longest time for which it has stood with wanted motion, s.
    stuck: f64,
}

impl Encoder {
    pub(super) fn at(angle: f64) -> Self {
        Self {
            angle,
            ..Self::default()
        }
    }

    /// Adds the reading after a step of `h` s, in which its joint was to move at `rate`, rad/s; the size of
    /// the unseen motion. `unmoved` is the least motion of a stand that may be a fault, rad.
    pub(super) fn add(&mut self, angle: f64, rate: f64, unmoved: f64, h: f64) -> f64 {
        if angle == self.angle {
            self.stands[0] += h;
            self.stands[1] += h * rate - share(h / FORGETS) * self.stands[1];
        } else {
            let [time, motion] = self.stands.map(f64::abs);
            self.most = [self.most[0].max(time), self.most[1].max(motion)];
            if motion > RESTS * unmoved {
                self.stuck = self.stuck.max(time);
            }
            (self.angle, self.stands) = (angle, [0.0; 2]);
        }
        self.stands[1].abs()
    }

    /// Whether it stands as it has not done before in a machine that was watched for a time, s, with
    /// more wanted motion than `unmoved`, rad.
    pub(super) fn is_stale(&self, looked: f64, unmoved: f64) -> bool {
        let ([time, motion], [longest, most]) = (self.stands.map(f64::abs), self.most);
        let is_new = |longest: f64, unmoved: f64| {
            time > STANDS.max(LONGER * longest)
                && motion > unmoved.max(LONGER * most)
                && looked > SHOWN[1] * longest
        };
        let sticks = is_new(longest, unmoved) || is_new(self.stuck / CERTAIN, CERTAIN * unmoved);
        sticks && looked - time > SHOWN[0]
    }
}
