//! Saved states of FMI 3.0.

use super::*;

/// Every call goes to the C functions with pointers that are valid for the slices they come from.
impl Fmu3 {
    pub fn save(&self) -> FmuState {
        let mut state = ptr::null_mut();
        // SAFETY: a live instance, a place for the handle.
        assert_eq!(unsafe { fmi3GetFMUState(self.c, &mut state) }, Status::Ok);
        state
    }

    pub fn restore(&self, state: FmuState) -> Status {
        // SAFETY: a live instance.
        unsafe { fmi3SetFMUState(self.c, state) }
    }

    pub fn free(&self, state: &mut FmuState) -> Status {
        // SAFETY: a live instance, a handle.
        unsafe { fmi3FreeFMUState(self.c, state) }
    }

    pub fn serialize(&self, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: a live instance; the vector has the size asked for.
        unsafe {
            assert_eq!(
                fmi3SerializedFMUStateSize(self.c, state, &mut size),
                Status::Ok
            );
            let mut bytes = vec![0_u8; size];
            assert_eq!(
                fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size),
                Status::Ok
            );
            bytes
        }
    }

    pub fn deserialize(&self, bytes: &[u8]) -> (Status, FmuState) {
        let mut state = ptr::null_mut();
        // SAFETY: a live instance, a valid slice.
        let status =
            unsafe { fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state) };
        (status, state)
    }

    /// All of the instance that can be saved, as bytes: to see that a refused call changed nothing.
    pub fn snapshot(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        assert_eq!(self.free(&mut state), Status::Ok);
        bytes
    }
}
