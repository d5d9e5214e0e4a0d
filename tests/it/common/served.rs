//! The program as it serves a page.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};

/// A program that serves a page, and where; it ends with the test.
pub struct Served {
    program: Child,
    told: BufReader<ChildStderr>,
    /// Where, as it is opened.
    pub address: String,
}

impl Served {
    /// In a folder, by the arguments of a command line.
    pub fn new(place: &Path, arguments: &[&str]) -> Served {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments);
        // A conversation ends with its standard input, which stays open as long as the program is held.
        Served::by(place, command, Stdio::piped())
    }

    /// The same where nobody types, as where a service starts it.
    pub fn unattended(place: &Path, arguments: &[&str]) -> Served {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments);
        Served::by(place, command, Stdio::null())
    }

    /// The same where a process may have no more than so many files open. What the processor was busy with, for the
    /// page and for all else, seconds, is told at the end.
    pub fn within(place: &Path, files: u32, arguments: &[&str]) -> Served {
        let mut command = Command::new("bash");
        let line = format!("ulimit -n {files}; TIMEFORMAT='took %R %U %S'; time \"$0\" \"$@\"");
        command.args(["-c", &line, env!("CARGO_BIN_EXE_bodyschema")]).args(arguments);
        Served::by(place, command, Stdio::piped())
    }

    fn by(place: &Path, mut command: Command, input: Stdio) -> Served {
        command.args(["--live", "127.0.0.1:0"]).current_dir(place).stdin(input);
        Served::started(command)
    }

    /// By a command as it is, wherever it serves.
    pub fn started(mut command: Command) -> Served {
        let mut program = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut told = BufReader::new(program.stderr.take().unwrap());
        let address = (&mut told)
            .lines()
            .map_while(Result::ok)
            .find_map(|line| Some(line.split_once("live at ")?.1.to_string()));
        Served {
            program,
            told,
            address: address.unwrap_or_else(|| panic!("{command:?} does not tell where it serves")),
        }
    }

    /// Where, as a host and a port.
    pub fn host(&self) -> &str {
        self.address.trim_start_matches("http://").trim_end_matches('/')
    }

    /// The answer to a request, its head as well.
    pub fn answer(&self, method: &str, path: &str, headers: &str, body: &str) -> String {
        let headers = headers.replace("HERE", self.host());
        let mut stream = TcpStream::connect(self.host()).unwrap();
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\n{headers}connection: close\r\ncontent-length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    /// Asks it to end, as the system does with a service.
    pub fn terminate(&self) {
        assert!(Command::new("kill").arg(self.program.id().to_string()).status().unwrap().success());
    }

    /// Waits until it ends by itself: how it ended, and what it said since it began to serve.
    pub fn end(mut self) -> (ExitStatus, String) {
        let mut said = String::new();
        self.told.read_to_string(&mut said).unwrap();
        (self.program.wait().unwrap(), said)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
