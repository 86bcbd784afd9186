//! What is made of a campaign's rows: fitted physics and a look-up map, and what each model says
//! that a motion under a load takes.

pub mod efficiency_map;
pub mod identification;
pub mod least_squares;
pub mod lookup;
pub mod model;
pub mod responses;
