//! A gateway's boards: the files of its own unit.

use std::time::Duration;

use super::{Client, ClientError, Patience};
use crate::hall::counters::{BOARD_STEP, FIRST_BOARD, OWN_UNIT};
use crate::hall::known::{
    Known, MOST_BYTES, Program, read_request, records_of, text_of, write_request,
};
use crate::link::Link;

/// Records in a request.
const RECORDS: usize = 120;
/// Wait for what a gateway answers by itself.
const REPLY: Duration = Duration::from_millis(500);

impl<L: Link> Client<L> {
    /// Everything that a gateway knows of its boards, in the order of its file; those that this client
    /// may not see are left out.
    ///
    /// # Errors
    /// See [`ClientError`]: what answers is no gateway.
    pub fn hall(&mut self) -> Result<Vec<Known>, ClientError> {
        self.as_gateway(|gateway| {
            let boards = gateway.input(0, 2)?[0];
            let mut hall = Vec::new();
            for n in 0..boards {
                let unit = gateway.input(FIRST_BOARD + BOARD_STEP * n, 1)?[0];
                match gateway.known(unit) {
                    Ok(known) => hall.push(known),
                    Err(ClientError::Exception(2)) => {}
                    Err(error) => return Err(error),
                }
            }
            Ok(hall)
        })
    }

    /// Leaves with the gateway what is known of the program that its board with this unit got.
    ///
    /// # Errors
    /// See [`ClientError`]: what answers is no gateway, or it does not let us.
    pub fn leave(&mut self, unit: u8, program: &Program) -> Result<(), ClientError> {
        let text = program.text();
        self.as_gateway(|gateway| {
            for (n, part) in records_of(&text).chunks(2 * RECORDS).enumerate() {
                let first = (n * RECORDS) as u16;
                let request = write_request(unit.into(), first, part);
                gateway.ask_own(&request, request.len())?;
            }
            Ok(())
        })
    }

    /// Asks the gateway itself for a while.
    fn as_gateway<T>(
        &mut self,
        ask: impl FnOnce(&mut Self) -> Result<T, ClientError>,
    ) -> Result<T, ClientError> {
        let board = self.address();
        let usual = self.set_patience(Patience { reply: REPLY, attempts: 1 });
        self.set_address(OWN_UNIT);
        let result = ask(self);
        self.set_address(board);
        self.set_patience(usual);
        result
    }

    fn known(&mut self, unit: u16) -> Result<Known, ClientError> {
        let mut records = Vec::new();
        let mut wanted = 1;
        while records.len() < 2 * wanted {
            let have = records.len() / 2;
            let count = (wanted - have).min(RECORDS);
            let request = read_request(unit, have as u16, count as u8);
            let reply = self.ask_own(&request, 4 + 2 * count)?;
            records.extend(reply.get(4..).unwrap_or_default());
            let length = u16::from_be_bytes([records[0], records[1]]);
            wanted = 1 + usize::from(length).min(MOST_BYTES).div_ceil(2);
        }
        let text = text_of(&records).unwrap_or_default();
        // Of another version of this tool nothing is understood.
        serde_json::from_slice(text).map_err(|_| ClientError::Noise(records.len()))
    }

    fn ask_own(&mut self, pdu: &[u8], length: usize) -> Result<Vec<u8>, ClientError> {
        let reply = self.pass_on(OWN_UNIT, pdu, length, false)?;
        match reply[..] {
            [function, code] if function & 0x80 != 0 => Err(ClientError::Exception(code)),
            _ => Ok(reply),
        }
    }
}
