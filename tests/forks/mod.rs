//! Forks of flights, and recordings compared.

mod library;
mod program;
