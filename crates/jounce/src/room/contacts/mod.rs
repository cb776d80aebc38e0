//! Contacts.
pub mod desc;
