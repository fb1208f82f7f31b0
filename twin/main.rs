//! The command line of `twin`. Results go to stdout, messages to stderr. Exit code 0: passed, 1: failed, 2: unusable input,
//! 128 + signal: interrupted.

mod cli;

fn main() -> std::process::ExitCode {
    twin_record::program::set_commit(option_env!("TWIN_GIT_ID").unwrap_or("unknown"));
    cli::main()
}
