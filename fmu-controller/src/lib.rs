//! FMU shell Controller.
