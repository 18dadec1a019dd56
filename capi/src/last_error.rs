//! The message of the last failing call on a thread.

use std::cell::Cell;
use std::ffi::c_char;
use std::fmt::{self, Write};

/// Bytes of a message with its closing NUL; a longer one is cut.
const MESSAGE_BYTES: usize = 512;

/// A text that C can read, in place: `bytes` comes first.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Message {
    bytes: [u8; MESSAGE_BYTES],
    len: usize,
}

impl Message {
    const EMPTY: Self = Self { bytes: [0; MESSAGE_BYTES], len: 0 };

    pub(crate) fn new(text: fmt::Arguments<'_>) -> Self {
        let mut message = Self::EMPTY;
        // The only error is "full", and then the text is cut.
        let _ = message.write_fmt(text);
        message
    }

    pub(crate) fn as_ptr(&self) -> *const c_char {
        self.bytes.as_ptr().cast()
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let character = if character == '\0' { '?' } else { character };
            let end = self.len + character.len_utf8();
            if end >= MESSAGE_BYTES {
                return Err(fmt::Error);
            }
            character.encode_utf8(&mut self.bytes[self.len..end]);
            self.len = end;
        }
        Ok(())
    }
}

thread_local! {
    // Constant and without a destructor, so that it can be used at any time in the life of a thread.
    static LAST: Cell<Message> = const { Cell::new(Message::EMPTY) };
}

pub(crate) fn set(message: Message) {
    LAST.with(|last| last.set(message));
}

/// Message of the last call that failed on this thread: the function, the argument at fault and what is wrong with it. UTF-8,
/// at most 511 bytes, for people: the wording may change, the codes do not.
///
/// @return a string owned by the library, never NULL, empty if no call failed on this thread; valid until the next failing
///         call on this thread or the end of the thread. Calls that succeed leave it as it is.
/// Threads: any thread at any time; each thread has its own. Callbacks: allowed.
#[unsafe(no_mangle)]
pub extern "C" fn ls_last_error_message_get() -> *const c_char {
    LAST.with(|last| last.as_ptr().cast())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_message_is_cut_at_a_character_and_closed() {
        let long = "é".repeat(MESSAGE_BYTES);
        let message = Message::new(format_args!("a{long}"));
        assert_eq!(message.len, MESSAGE_BYTES - 1);
        assert_eq!(message.bytes[MESSAGE_BYTES - 1], 0);
        assert!(std::str::from_utf8(&message.bytes[..message.len]).is_ok());
        let message = Message::new(format_args!("ab{long}"));
        assert_eq!((message.len, message.bytes[message.len]), (MESSAGE_BYTES - 2, 0));
    }
}
