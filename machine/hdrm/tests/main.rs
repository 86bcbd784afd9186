//! Tests of the manipulator in one program. What counts allocations has a program of its own.
#![allow(non_snake_case)] // symbols

mod contact;
mod damaged;
mod end_stops;
mod identities;
mod kinematics;
mod moving_base;
mod oracle;
mod overflow;
mod paper_angles;
mod printed_forces;
mod rates;
mod seeded;
mod wrist_brakes;
