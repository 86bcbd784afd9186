//! Saved states, which both versions of FMI handle alike.

/// Gives an importer's instance what it needs of saved states, by the names of the six C functions.
macro_rules! saved_states {
    ($fmu:ident: $get:ident $set:ident $free:ident $size:ident $serialize:ident $deserialize:ident) => {
        /// Every call goes to the C functions with pointers that are valid for the slices they come
        /// from.
        impl $fmu {
            pub fn save(&self) -> FmuState {
                let mut state = ptr::null_mut();
                // SAFETY: a live instance, a place for the handle.
                assert_eq!(unsafe { $get(self.c, &mut state) }, Status::Ok);
                state
            }

            pub fn restore(&self, state: FmuState) -> Status {
                // SAFETY: a live instance.
                unsafe { $set(self.c, state) }
            }

            pub fn free(&self, state: &mut FmuState) -> Status {
                // SAFETY: a live instance, a handle.
                unsafe { $free(self.c, state) }
            }

            pub fn serialize(&self, state: FmuState) -> Vec<u8> {
                let mut size = 0;
                // SAFETY: a live instance; the vector has the size asked for.
                unsafe {
                    assert_eq!($size(self.c, state, &mut size), Status::Ok);
                    let mut bytes = vec![0_u8; size];
                    let to = bytes.as_mut_ptr().cast();
                    assert_eq!($serialize(self.c, state, to, size), Status::Ok);
                    bytes
                }
            }

            pub fn deserialize(&self, bytes: &[u8]) -> (Status, FmuState) {
                let mut state = ptr::null_mut();
                // SAFETY: a live instance, a valid slice.
                let status =
                    unsafe { $deserialize(self.c, bytes.as_ptr().cast(), bytes.len(), &mut state) };
                (status, state)
            }

            /// All of the instance that can be saved, as bytes: to see that a refused call changed
            /// nothing.
            pub fn snapshot(&self) -> Vec<u8> {
                let mut state = self.save();
                let bytes = self.serialize(state);
                assert_eq!(self.free(&mut state), Status::Ok);
                bytes
            }
        }
    };
}
pub(crate) use saved_states;
