//! The opcode table: the one place where an instruction is described, but for those of plain statements,
//! whose rows are [`crate::plain`]'s and come last.
//!
//! A row is `code x count Name "mnemonic" Operands pops pushes Class "what it does"`.
//! With `count` above 1 the instruction has that many codes and `n` is the code's distance from
//! the first. Operands of effects that bring a variable number of arguments count theirs in
//! [`super::argument_masks`].

/// Hands all rows to a macro: `lang` makes [`super::Op`] and [`super::ROWS`] of them, the firmware the
/// jump table of its VM.
#[macro_export]
macro_rules! opcode_rows {
    ($consumer:ident) => {
        $crate::plain_rows! { [$crate::opcode_rows] @with $consumer }
    };
    (@with $consumer:ident
     $($name:ident $text:literal $code:literal $mnemonic:literal $count:literal [$($argument:ident)*]
       $touch:ident $manner:ident $usage:literal $about:literal $doc:literal;)*) => {
        $consumer! {
            // Flow and constants. 0xFF, erased flash, is no instruction.
            0x00 x 1 End "end" None 0 0 Ends "the run ends";
            0x01 x 1 Byte "byte" I8 0 1 Pure "push i8";
            0x02 x 1 Tens "tens" U8 0 1 Pure "push u8 * 10";
            0x03 x 1 Hundreds "hundreds" I8 0 1 Pure "push i8 * 100";
            0x04 x 1 Thousands "thousands" I8 0 1 Pure "push i8 * 1000";
            0x05 x 1 Word "word" I16 0 1 Pure "push i16";
            0x06 x 1 WordTens "wordtens" I16 0 1 Pure "push i16 * 10";
            0x07 x 1 Long "long" I32 0 1 Pure "push i32";
            // Cells and arrays.
            0x08 x 1 LoadFar "loadfar" Cell 0 1 Pure "push cell";
            0x09 x 1 StoreFar "storefar" Cell 1 0 Pure "cell = pop";
            0x0A x 1 Inc "inc" Cell 0 0 Pure "cell += 1; F01";
            0x0B x 1 AddCell "addcell" Cell 1 1 Pure "top + cell; F01";
            0x0C x 1 LoadElem "loadelem" Array 1 1 Pure "i = pop; F03 unless 0 <= i < len; push cell[first + i]";
            0x0D x 1 StoreElem "storeelem" Array 2 0 Pure "v = pop; i = pop; F03 unless 0 <= i < len; cell[first + i] = v";
            // Arithmetic: right = pop, left = pop where there are two.
            0x0E x 1 Shl "shl" None 2 1 Pure "left << right, bits drop; F04 unless 0 <= right <= 31";
            0x0F x 1 Shr "shr" None 2 1 Pure "left >> right, arithmetic; F04 unless 0 <= right <= 31";
            0x10 x 1 Add "add" None 2 1 Pure "left + right; F01";
            0x11 x 1 Sub "sub" None 2 1 Pure "left - right; F01";
            0x12 x 1 Mul "mul" None 2 1 Pure "left * right; F01";
            0x13 x 1 Div "div" None 2 1 Pure "left / right toward zero; F02, F01";
            0x14 x 1 Mod "mod" None 2 1 Pure "remainder with the sign of left; F02; least number by -1 is 0";
            0x15 x 1 Min "min" None 2 1 Pure "the lesser";
            0x16 x 1 Max "max" None 2 1 Pure "the greater";
            0x17 x 1 And "and" None 2 1 Pure "bitwise and";
            0x18 x 1 Or "or" None 2 1 Pure "bitwise or";
            // In a comparison's code bit 0 is less, bit 1 equal, bit 2 greater.
            0x19 x 1 Lt "lt" None 2 1 Pure "1 if left < right, else 0";
            0x1A x 1 Eq "eq" None 2 1 Pure "1 if left = right, else 0";
            0x1B x 1 Le "le" None 2 1 Pure "1 if left <= right, else 0";
            0x1C x 1 Gt "gt" None 2 1 Pure "1 if left > right, else 0";
            0x1D x 1 Ne "ne" None 2 1 Pure "1 if left <> right, else 0";
            0x1E x 1 Ge "ge" None 2 1 Pure "1 if left >= right, else 0";
            0x1F x 1 Xor "xor" None 2 1 Pure "bitwise exclusive or";
            0x20 x 1 Neg "neg" None 1 1 Pure "-pop; F01";
            0x21 x 1 Abs "abs" None 1 1 Pure "absolute value; F01";
            0x22 x 1 Sqr "sqr" None 1 1 Pure "integer root; F20 below 0";
            0x23 x 1 Drop "drop" None 1 0 Pure "pop";
            // Jumps; a relative distance counts from the end of the instruction.
            0x24 x 1 JumpZero "jumpzero" Rel 1 0 Pure "jump if pop = 0";
            0x25 x 1 JumpNonzero "jumpnonzero" Rel 1 0 Pure "jump if pop <> 0";
            0x26 x 1 Jump "jump" Rel 0 0 Ends "pc += i8";
            0x27 x 1 JumpFar "jumpfar" Addr 0 0 Ends "pc = address";
            0x28 x 1 Dup "dup" None 1 2 Pure "push top";
            0x29 x 1 JumpLt "jumplt" Rel 2 0 Pure "jump if left < right";
            0x2A x 1 JumpEq "jumpeq" Rel 2 0 Pure "jump if left = right";
            0x2B x 1 JumpLe "jumple" Rel 2 0 Pure "jump if left <= right";
            0x2C x 1 JumpGt "jumpgt" Rel 2 0 Pure "jump if left > right";
            0x2D x 1 JumpNe "jumpne" Rel 2 0 Pure "jump if left <> right";
            0x2E x 1 JumpGe "jumpge" Rel 2 0 Pure "jump if left >= right";
            0x2F x 1 Over "over" None 2 3 Pure "push the value below top";
            // Loops.
            0x30 x 1 ForStep "forstep" CellRel 2 0 Pure "step = pop; limit = pop; F20 if step = 0; jump if cell lies beyond limit";
            0x31 x 1 NextStep "nextstep" CellRel 2 0 Pure "step = pop; limit = pop; cell += step, F01; jump unless cell lies beyond limit";
            0x32 x 1 NextWord "nextword" CellWordRel 0 0 Pure "cell += 1, F01; jump if cell <= i16";
            0x33 x 1 Table "table" Column8 1 1 Pure "i = pop; F03 unless a row; push column[i]";
            0x34 x 4 NextShort "nextshort" U8Rel 0 0 Pure "cell[n] += 1, F01; jump if cell[n] <= u8";
            0x38 x 4 IncShort "incshort" None 0 0 Pure "cell[n] += 1; F01";
            0x3C x 4 Zero "zero" None 0 0 Pure "cell[n] = 0";
            // Calls. An entry of the call stack holds the return address and its kind.
            0x40 x 1 Call "call" Sub8 0 0 Pure "call a SUB; F16 when the call stack is full";
            0x41 x 1 CallFar "callfar" Sub 0 0 Pure "call a SUB; F16";
            0x42 x 1 Gosub "gosub" Sub 0 0 Pure "GOSUB; F16";
            0x43 x 1 Func "func" Sub 0 1 Pure "call a FUNCTION; F16";
            0x44 x 1 Return "return" None 0 0 Ends "return from GOSUB, SUB or event handler; F16 when none is open";
            0x45 x 1 ExitSub "exitsub" None 0 0 Ends "drop open GOSUBs, then return from SUB or event handler; F16";
            0x46 x 1 Give "give" None 1 0 Ends "drop open GOSUBs, then return from FUNCTION; the top stays as its result; F16";
            // Tables and the profile.
            0x47 x 1 TableFar "tablefar" Column 1 1 Pure "i = pop; F03 unless a row; push column[i]";
            0x48 x 1 Check "check" U8 1 1 Pure "F03 unless 0 <= top < u8";
            // What the host knows of a path that begins: [`crate::image::course`].
            0x49 x 1 Course "course" Text 0 0 Pure "slow points of the lines that follow, as far as none are open";
            0x4A x 1 ToSteps "tosteps" Axis 1 1 Pure "um to steps by the profile, half away from zero; F01";
            0x4B x 1 ToLength "tolength" Axis 1 1 Pure "steps to um by the profile, half away from zero; F01";
            // Errors. Statement table: [`crate::image::statements`].
            0x4C x 1 Err "err" None 0 1 Pure "number of the last fault, 0 before one";
            0x4D x 1 Erl "erl" None 0 1 Pure "line of the last fault, 0 before one";
            0x4E x 1 Leave "leave" None 0 0 Pure "in an error handler itself: drop all calls and leave all handlers";
            0x4F x 1 OnError "onerror" Sub 0 0 Pure "error handler = address";
            0x50 x 1 OnErrorStop "onerrorstop" None 0 0 Pure "no error handler";
            0x51 x 1 ResumeNext "resumenext" None 0 0 Ends "go on after the statement that failed; F16 outside an error handler";
            0x52 x 1 More "more" None 0 0 Pure "the next effect does not end its statement: serve no event behind it";
            // From here to 0x5F instructions that only larger parts have; the fingerprint leaves them out, a feature
            // says who has them.
            0x53 x 1 Resume "resume" None 0 0 Ends "the statement that failed again; F16 outside an error handler";
            0x54 x 1 Sin "sin" None 1 1 Pure "sine of 1/1000 degrees, in 1/10000";
            0x55 x 1 Cos "cos" None 1 1 Pure "cosine of 1/1000 degrees, in 1/10000";
            0x56 x 1 Atan2 "atan2" None 2 1 Pure "angle of (left, right) = (y, x), 1/1000 degrees";
            0x57 x 1 MulDiv "muldiv" None 3 1 Pure "over = pop, times = pop; top * times / over, half away from zero; F02, F01";
            0x58 x 1 Sync "sync" U8 3 0 Effect "SYNC: n, level, ms or value, lead; the output acts where the path's next block begins";
            0x59 x 1 SetAout "setaout" None 2 0 Effect "SetAout n, value";
            // Short forms.
            0x60 x 32 Small "small" None 0 1 Pure "push n";
            0x80 x 16 Load "load" None 0 1 Pure "push cell[n]";
            0x90 x 16 Store "store" None 1 0 Pure "cell[n] = pop";
            // Effects whose values, whole thousands, stand in the code instead of on the stack. These and the
            // others stand beside those that are alike to the image check, which has one entry for a run.
            0xA0 x 3 MoveToMm "movetomm" Mm 0 0 Effect "MoveAxe axis n, i8 mm";
            0xA3 x 2 LineMm "linemm" Mm 0 0 Effect "G1 X or Y, i8 mm";
            0xA5 x 1 LineZMm "linezmm" Mm 0 0 Effect "G1 Z, i8 mm";
            0xA6 x 1 RapidZMm "rapidzmm" Mm 0 0 Effect "G0 Z, i8 mm";
            0xA7 x 1 FeedMm "feedmm" Mm 0 0 Effect "F, i8 mm/s";
            0xA8 x 1 WaitSeconds "waitseconds" Mm 0 0 Effect "Wait i8 s";
            0xA9 x 1 RapidXyMm "rapidxymm" Mm2 0 0 Effect "G0 XY, i8 mm each";
            0xAA x 1 LineXyMm "linexymm" Mm2 0 0 Effect "G1 XY, i8 mm each";
            0xAB x 1 LinearMm "linearmm" MmFlags 0 0 Effect "linear with one word, i8 mm";
            0xAC x 1 LinearMm2 "linearmm2" Mm2Flags 0 0 Effect "linear with two words, i8 mm each";
            0xAD x 1 LinearMm3 "linearmm3" Mm3Flags 0 0 Effect "linear with three words, i8 mm each";
            0xAE x 1 MoveMm "movemm" Mm2Flags 0 0 Effect "move with target, i8 mm, and speed, i8 mm/s";
            0xAF x 1 ProbeMm "probemm" Mm2Flags2 0 0 Effect "probe with limit, i8 mm, and speed, i8 mm/s";
            // Effects: the VM leaves with the arguments on the stack.
            0xB0 x 1 WaitMove "waitmove" Flags 0 0 Effect "WaitMove; 3 is all axes";
            0xB1 x 1 Linear "linear" Flags 0 0 Effect "G0 or G1: one value for each axis named";
            0xB2 x 1 LinearMixed "linearmixed" Flags2 0 0 Effect "G0 or G1 with a unit and a frame for each axis";
            0xB3 x 5 Rapid "rapid" None 0 0 Effect "G0, absolute um: X, Y, XY, Z, XYZ";
            0xB8 x 5 Line "line" None 0 0 Effect "G1, absolute um: X, Y, XY, Z, XYZ";
            0xBD x 3 MoveTo "moveto" None 1 0 Effect "MoveAxe axis n, um";
            0xC0 x 3 MoveBy "moveby" None 1 0 Effect "MoveRel axis n, um";
            0xC3 x 1 Move "move" Flags 1 0 Effect "MoveAxe or MoveRel: target[, speed]";
            0xC4 x 1 MoveRamp "moveramp" Flags2 1 0 Effect "MoveAxe or MoveRel: target[, speed][, accel][, decel]";
            0xC5 x 1 Probe "probe" Flags2 1 0 Effect "Probe: limit[, speed][, input, state | and, xor]";
            0xC6 x 3 Home "home" None 0 0 Effect "Home axis n";
            0xC9 x 1 HomeQuery "homequery" Axis 0 0 Effect "Home? axis";
            0xCA x 1 StopAxe "stopaxe" Axis 0 0 Effect "StopAxe";
            0xCC x 3 SetPosZero "setposzero" None 0 0 Effect "SetPos axis n, 0";
            0xCF x 16 OutShort "out" None 0 0 Effect "SetOut n / 2 + 1, n AND 1";
            0xDF x 1 PrintEnd "printend" None 0 0 Effect "PRINT's line is complete";
            0xE3 x 1 WaitIn "waitin" Flags 0 0 Effect "WaitIn [n][, level][, ms]";
            0xE4 x 1 Motors "motors" Flags 1 0 Effect "Motors on; 3 is all axes";
            0xE5 x 1 WaitChar "waitchar" Flags 1 0 Effect "WaitChar c[, ms]";
            0xE9 x 1 Feed "feed" None 1 0 Effect "F in um/s";
            0xEA x 1 FeedSteps "feedsteps" None 1 0 Effect "F in steps/s";
            0xEB x 1 Spindle "spindle" None 1 0 Effect "S";
            0xEC x 1 PrintNumber "printnumber" None 1 0 Effect "a value of PRINT; its unit is text";
            0xED x 1 PrintText "printtext" Text8 0 0 Effect "a text of PRINT";
            0xEE x 1 PrintTextFar "printtextfar" Text 0 0 Effect "a text of PRINT";
            0xEF x 1 SetPos "setpos" Axis 1 0 Effect "SetPos axis, um";
            0xF0 x 4 InShort "inshort" None 0 1 Effect "IN(n + 1)";
            0xF4 x 1 TimedOut "timedout" None 0 1 Effect "TIMEDOUT";
            0xF5 x 1 In "in" None 1 1 Effect "IN(n)";
            0xF6 x 1 Out "outstate" None 1 1 Effect "OUT(n)";
            0xF7 x 1 Read "read" Flags 0 1 Effect "another look at the machine";
            0xF8 x 1 MoveSpeed "movespeed" Flags 1 0 Effect "MoveSpeed axis, speed";
            0xF9 x 1 Arc "arc" Flags 1 0 Effect "G2 or G3, absolute um: axes, then I J K of the plane or R";
            0xFA x 1 ArcMixed "arcmixed" Flags3 1 0 Effect "G2 or G3 with a unit and a frame for each word";
            0xFB x 1 ArcBy "arcby" Flags 1 0 Effect "G2 or G3, relative um: axes, then I J K of the plane or R";
            0xFC x 1 Event "event" Flags 0 0 Effect "ON IN n, ON EVERY ms and their OFF";
            0xFD x 1 Run "run" Text 0 0 Effect "RUN: the run ends, the program of this name begins";
            $($code x 1 $name $mnemonic None $count 0 Effect $doc;)*
        }
    };
}
