//! emla
