//! Models of the actuator that are fitted to a campaign's rows, and the current and efficiency that
//! they predict for a motion under a load.

pub mod efficiency_map;
pub mod identification;
pub mod least_squares;
pub mod lookup;
pub mod model;
pub mod responses;
