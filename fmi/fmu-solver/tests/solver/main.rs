//! Solvers against closed forms, and stiff problems against SciPy.

mod accuracy;
mod events;
mod failures;
mod problem;
mod stiff;
