//! Models of the actuator, most of them fitted to a campaign's rows, and the current and efficiency
//! that they predict for a motion under a load; for the judgement, `report` and `experiments`.

pub mod efficiency_map;
pub mod identification;
pub mod least_squares;
pub mod lookup;
pub mod model;
pub mod responses;
