//! FMU shell Emla.
