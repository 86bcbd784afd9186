//! FMU shell Hdrm.
